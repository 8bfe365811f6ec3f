"""RP and its interval by the formulas of docs/repeatability.md, in plain Python."""

import math
from statistics import NormalDist, mean, stdev

Z = NormalDist().inv_cdf(0.975)


def lengths(components):
    """Return the distances of the positions to their barycentre."""
    centre = [mean(values) for values in components]
    return [math.dist(position, centre) for position in zip(*components, strict=True)]


def rp(components):
    found = lengths(components)
    return mean(found) + 3 * stdev(found)


def rss(components):
    return math.sqrt(sum(rp([values]) ** 2 for values in components))


def three_sigma(components):
    return 3 * stdev(components[0])


def jackknife(figure, components):
    """Return the error of ln figure by leaving out each reading, and the mean ln without one."""
    n = len(components[0])
    without = [
        math.log(figure([values[:k] + values[k + 1 :] for values in components])) for k in range(n)
    ]
    error = math.sqrt((n - 1) / n * sum((log - mean(without)) ** 2 for log in without))
    return error, mean(without)


def below(error, z=Z):
    return (1 - 4 / 9 * error**2 + 2 / 3 * z * error) ** -1.5


def above(error, z=Z):
    return math.exp(z * error + (z**2 + 2) / 3 * error**2)


def limits(figure, gaussian, gaussian_error, components, steps=None):
    """Return the 95 % limits: jackknife of ln figure, chi-square, shortfall, rounding."""
    n, q = len(components[0]), len(components)
    value = figure(components)
    error, log_without = jackknife(figure, components)
    error = max(error, gaussian_error / math.sqrt(n - 1))
    shortfall = (n - 1) * (math.log(value) - log_without)
    upper = value * above(error) * math.exp(3 * max(shortfall, 0))
    lower = value * below(error)
    if steps:
        variance = sum(stdev(values) ** 2 for values in components)
        share = 1 - sum(step**2 for step in steps) / 12 / variance
        if variance < 4 * sum(step**2 for step in steps):
            lower *= min(value, gaussian * math.sqrt(variance / q)) / value
        lower *= math.sqrt(share)
    return lower, upper
