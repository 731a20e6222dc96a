from uav_tracking_mpc.control.event import CAPACITY, EventLog, Level


def test_events_are_taken_once_oldest_first():
    log = EventLog()
    log.add(Level.INFO, "one")
    log.add(Level.WARNING, "two")
    assert log.take() == [(Level.INFO, "one"), (Level.WARNING, "two")]
    assert log.take() == []


def test_what_nobody_takes_does_not_grow():
    log = EventLog()
    for number in range(CAPACITY + 5):
        log.add(Level.INFO, str(number))
    events = log.take()
    assert (len(events), events[0].words) == (CAPACITY, "5")
