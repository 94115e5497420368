#!/usr/bin/env python3
"""How often intervals and tests of `earpoint study report` err on random studies (docs/adr/0021-study-statistics.md).

Usage: python3 experiments/measure/study_statistics.py [REPETITIONS]
Two methods are equally good over all people and clips, but every participant and every clip prefers one of them.
"""
import sys
from math import comb

import numpy as np

DRAWS = 400
ALPHA = 0.05


def p_of_sign_test(wins, losses):
    votes = wins + losses
    tail = sum(comb(votes, k) for k in range(min(wins, losses) + 1)) / 2**votes
    return min(1.0, 2 * tail)


def votes_of(totals):
    return p_of_sign_test(int((totals > 0).sum()), int((totals < 0).sum()))


def holds(random, answers, over_participants, over_clips):
    """Whether the percentile interval of the share holds one half."""
    participants, clips = answers.shape
    even = np.ones((DRAWS, participants)), np.ones((DRAWS, clips))
    weights_p = random.multinomial(participants, np.full(participants, 1 / participants), DRAWS) if over_participants else even[0]
    weights_c = random.multinomial(clips, np.full(clips, 1 / clips), DRAWS) if over_clips else even[1]
    shares = np.einsum("dp,pc,dc->d", weights_p, answers, weights_c) / (participants * clips)
    low, high = np.quantile(shares, [ALPHA / 2, 1 - ALPHA / 2])
    return low <= 0.5 <= high


def measure(random, participants, clips, lean, repetitions):
    errors = np.zeros(7)
    for _ in range(repetitions):
        logit = lean * random.standard_normal((participants, 1)) + lean * random.standard_normal((1, clips))
        answers = (random.random((participants, clips)) < 1 / (1 + np.exp(-logit))).astype(float)
        signs = 2 * answers - 1
        share, count = answers.mean(), answers.size
        errors += [
            votes_of(signs) < ALPHA,
            votes_of(signs.sum(axis=1)) < ALPHA,
            votes_of(signs.sum(axis=0)) < ALPHA,
            abs(share - 0.5) > 1.96 * np.sqrt(share * (1 - share) / count),
            not holds(random, answers, True, False),
            not holds(random, answers, False, True),
            not holds(random, answers, True, True),
        ]
    return 100 * errors / repetitions


def main():
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    random = np.random.default_rng(1)
    print("| participants, clips, lean | sign test over answers | over participants | over clips "
          "| binomial interval | bootstrap of participants | of clips | of both |")
    print("|---|---|---|---|---|---|---|---|")
    for participants, clips, lean in [(20, 20, 0.0), (20, 20, 0.5), (20, 20, 1.0), (12, 40, 1.0)]:
        errors = measure(random, participants, clips, lean, repetitions)
        print(f"| {participants}, {clips}, {lean:g} | " + " | ".join(f"{e:.0f} %" for e in errors) + " |")


if __name__ == "__main__":
    main()
