use super::*;

const MS: i64 = 1_000_000;

/// Poses due at 1000, 1010, ... 1090 ms of the recorded run.
struct Driven {
    transport: Transport,
    place: usize,
    now: i64,
    /// Which pose was published, at which moment of the machine's clock, and what the replay's clock showed then.
    published: Vec<(usize, i64, i64)>,
}

fn due(i: usize) -> i64 {
    (1000 + 10 * i as i64) * MS
}

impl Driven {
    fn new(speed: Speed, looping: bool) -> Self {
        Self {
            transport: Transport::new([due(0), due(9)], due(0), speed, looping),
            place: 0,
            now: 5_000_000 * MS,
            published: Vec::new(),
        }
    }

    /// Does what is decided until nothing is left to do before `until` of the machine's clock.
    fn drive(&mut self, until: i64) {
        loop {
            let due_ns = (self.place < 10).then(|| due(self.place));
            match self.transport.next(due_ns, self.now) {
                Act::Publish => {
                    let shown = self.transport.law().at(self.now);
                    self.published.push((self.place, self.now, shown));
                    self.place += 1;
                }
                Act::Find(at) => self.place = (0..10).find(|&i| due(i) >= at).unwrap_or(10),
                Act::Sleep(when) if when <= until => self.now = when,
                Act::Sleep(_) | Act::Idle => {
                    self.now = until;
                    return;
                }
            }
        }
    }

    fn places(&self) -> Vec<usize> {
        self.published.iter().map(|p| p.0).collect()
    }
}

#[test]
fn poses_go_out_when_the_clock_shows_their_stamp() {
    for times in [0.25, 1.0, 2.0] {
        let mut driven = Driven::new(Speed::Times(times), false);
        let start = driven.now;
        driven.drive(start + 1000 * MS);
        assert_eq!(driven.places(), (0..10).collect::<Vec<_>>());
        for &(i, at, shown) in &driven.published {
            let expected = start + (10.0 * i as f64 / times) as i64 * MS;
            assert_eq!((at, shown), (expected, due(i)), "pose {i} at speed {times}");
        }
        assert_eq!(driven.transport.state(), ReplayState::Ended);
    }
}

/// A step at the last pose ended the whole run.
#[test]
fn a_step_behind_the_last_pose_stands_still() {
    let mut driven = Driven::new(Speed::Times(1.0), false);
    driven.drive(driven.now);
    driven.transport.control(Control::Show(due(9)), driven.now);
    driven.drive(driven.now + MS);
    for _ in 0..2 {
        driven.transport.control(Control::Step, driven.now);
        driven.drive(driven.now + MS);
        assert_eq!(driven.transport.state(), ReplayState::Paused);
    }
    assert_eq!(driven.places().last(), Some(&9));
}

#[test]
fn a_pose_that_is_to_be_shown_is_shown_and_nothing_behind_it() {
    for ended in [false, true] {
        let mut driven = Driven::new(Speed::Times(1.0), false);
        let start = driven.now;
        driven.drive(start + if ended { 1000 } else { 55 } * MS);
        driven.published.clear();
        driven.transport.control(Control::Show(due(3)), driven.now);
        driven.drive(start + 2000 * MS);
        assert_eq!(driven.places(), [3], "ended: {ended}");
        assert_eq!(driven.transport.state(), ReplayState::Paused);
        assert_eq!(driven.transport.law().at(driven.now), due(3));
        driven.transport.control(Control::Step, driven.now);
        driven.drive(start + 3000 * MS);
        assert_eq!(driven.places(), [3, 4]);
    }
}

#[test]
fn at_full_speed_the_clock_stands_at_each_pose() {
    let mut driven = Driven::new(Speed::Max, false);
    let start = driven.now;
    driven.drive(start);
    assert_eq!(driven.places(), (0..10).collect::<Vec<_>>());
    assert!(
        driven
            .published
            .iter()
            .all(|&(i, at, shown)| at == start && shown == due(i))
    );
    assert_eq!(driven.transport.message(0).rate, 0.0);
}

#[test]
fn a_pause_stops_the_clock_and_play_goes_on_where_it_was() {
    let mut driven = Driven::new(Speed::Times(1.0), false);
    let start = driven.now;
    driven.drive(start + 25 * MS);
    driven.transport.control(Control::Pause, driven.now);
    driven.drive(start + 500 * MS);
    assert_eq!(driven.places(), [0, 1, 2]);
    assert_eq!(driven.transport.law().at(driven.now), due(0) + 25 * MS);
    driven.transport.control(Control::Step, driven.now);
    driven.drive(start + 501 * MS);
    assert_eq!(driven.published.last(), Some(&(3, start + 500 * MS, due(3))));
    driven.transport.control(Control::Play, driven.now);
    driven.drive(start + 511 * MS);
    assert_eq!(driven.published.last(), Some(&(4, start + 511 * MS, due(4))));
}

#[test]
fn seeking_finds_the_pose_and_says_that_it_jumped() {
    let mut driven = Driven::new(Speed::Times(1.0), false);
    let start = driven.now;
    driven.drive(start + 45 * MS);
    driven.transport.control(Control::Seek(due(1) + 1), driven.now);
    assert_eq!(driven.transport.message(0).jumps, 1);
    driven.drive(start + 45 * MS + 10 * MS);
    assert_eq!(driven.places(), [0, 1, 2, 3, 4, 2]);
    // Paused, the place that was asked for is shown, and nothing more.
    driven.transport.control(Control::Pause, driven.now);
    driven.transport.control(Control::Seek(i64::MAX), driven.now);
    driven.drive(start + 1000 * MS);
    assert_eq!(driven.places().last(), Some(&9));
    assert_eq!(driven.transport.state(), ReplayState::Paused);
}

#[test]
fn the_end_is_an_end_until_somebody_seeks() {
    let mut driven = Driven::new(Speed::Max, false);
    driven.drive(driven.now);
    for control in [Control::Play, Control::Step, Control::Pause] {
        driven.transport.control(control, driven.now);
        driven.drive(driven.now);
        assert_eq!(
            (driven.places().len(), driven.transport.state()),
            (10, ReplayState::Ended)
        );
    }
    driven.transport.control(Control::Seek(due(8)), driven.now);
    driven.drive(driven.now);
    assert_eq!(driven.places()[10..], [8, 9]);
}

#[test]
fn a_loop_begins_anew_without_losing_a_pose() {
    let mut driven = Driven::new(Speed::Times(1.0), true);
    let start = driven.now;
    // A round takes 90 ms from the first pose to the last, which is also the first moment of the next round.
    driven.drive(start + 215 * MS);
    let twice: Vec<usize> = (0..10).chain(0..10).chain(0..4).collect();
    assert_eq!(driven.places(), twice);
    assert_eq!(driven.transport.message(0).jumps, 2);
}

#[test]
fn another_speed_goes_on_from_the_same_moment() {
    let mut driven = Driven::new(Speed::Times(1.0), false);
    let start = driven.now;
    driven.drive(start + 12 * MS);
    driven.transport.control(Control::Speed(Speed::Times(0.5)), driven.now);
    driven.drive(start + 28 * MS);
    assert_eq!(driven.published.last(), Some(&(2, start + 28 * MS, due(2))));
    driven.transport.control(Control::Speed(Speed::Max), driven.now);
    driven.drive(driven.now);
    assert_eq!(driven.places().len(), 10);
}
