"""How many jobs make a task of a cluster."""

from jointplay.jobs.worker import FILL, Done, Pace


def test_tasks_begin_with_one_job_and_grow_until_they_fill_their_time():
    pace = Pace()
    assert pace.size(1000, 2) == 1
    pace.learn(Done(1, FILL / 10, {}, None))
    assert pace.size(1000, 2) == 10
    pace.learn(Done(10, FILL, {}, None))
    assert pace.size(1000, 2) == 10
    pace.learn(Done(9, 8.9 * FILL, {}, None))
    assert pace.size(1000, 2) == 2


def test_tasks_shrink_towards_the_end_so_that_workers_end_together():
    pace = Pace()
    pace.learn(Done(100, FILL, {}, None))
    assert [pace.size(left, 2) for left in (1000, 80, 8, 1)] == [100, 10, 1, 1]
