"""What a call of native code is told and tells: the words of its control block, and what it returns."""

from __future__ import annotations

from enum import IntEnum


class Word(IntEnum):
    """The words of the control block of a call; periods and counts of the rates follow."""

    TIME = 0
    UNTIL = 1
    STEP = 2
    ORIGIN = 3
    ROW_PERIOD = 4
    INTEGRAL_PERIOD = 5
    MOST_ROWS = 6
    TICKS_LEFT = 7
    SELECTED = 8
    SELECTED_COUNT = 9
    ROWS = 10
    ROW_TIMES = 11
    INTEGRALS = 12
    ACTIVITIES = 13
    INTEGRAL_TIMES = 14
    ROWS_WRITTEN = 15
    INTEGRAL_ROWS_WRITTEN = 16
    ROWS_TAKEN = 17
    INTEGRAL_ROWS_TAKEN = 18
    STEPS_TAKEN = 19
    JACOBIAN_EVERY = 20
    TOLERANCE = 21
    NEXT_STEP = 22
    LAST_ERROR = 23
    STEPS_REJECTED = 24
    LEAST = 25  # of the signals since the last row; 0 where nobody asks
    GREATEST = 26
    LEAST_ROWS = 27
    GREATEST_ROWS = 28
    FASTEST = 29
    NEXT_LOOK = 30
    FIRST_RATE = 31


class Code(IntEnum):
    """What `run` returns."""

    FINISHED = 0
    PAUSED = 1
    STATE_FAILED = 2  # in some lane that is alive
    ALL_FAILED = 3  # no lane is alive after a solve
    EVENT = 4  # the step that would meet an event was taken back
    STEP_TOO_SMALL = 5  # no step is short enough for the tolerance
