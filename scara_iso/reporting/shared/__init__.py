"""What several documents share: blocks, digits, figures, limits, what is stated, languages."""
