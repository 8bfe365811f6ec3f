"""An indicator on a pseudo-terminal, in a process of its own.

Prints the device's name, then answers each request by the next of the answers on its command
line: a text to send (``\\r`` as written in Python), ``-`` for silence, ``N:TEXT`` to send after
N seconds, ``unplug`` or ``unplug:TEXT`` to send TEXT and vanish; a last ``push:SECONDS`` sends
what is left by itself. The last answer is repeated.
"""

import os
import pty
import sys
import time
import tty


def unescaped(text):
    return text.encode("ascii").decode("unicode_escape").encode("latin-1")


def send(master, answer):
    word, _, rest = answer.partition(":")
    if word == "unplug":
        os.write(master, unescaped(rest))
        time.sleep(0.05)
        sys.exit()
    if word.replace(".", "", 1).isdigit() and rest:
        time.sleep(float(word))
        answer = rest
    if answer != "-":
        os.write(master, unescaped(answer))


def main():
    answers = sys.argv[1:]
    master, slave = pty.openpty()
    tty.setraw(slave)
    sys.stdout.write(os.ttyname(slave) + "\n")
    sys.stdout.flush()
    if answers[-1].startswith("push:"):
        push(master, answers[:-1], float(answers[-1][5:]))
    k = 0
    while request := os.read(master, 64):
        if request == b"UNI?\r":
            os.write(master, b"MM\r")
            continue
        send(master, answers[min(k, len(answers) - 1)])
        k += 1


def push(master, answers, seconds):
    for answer in answers:
        time.sleep(seconds)
        send(master, answer)
    time.sleep(60)


main()
