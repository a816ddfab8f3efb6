use proptest::prelude::*;

use super::*;

const LIMITS: Limits = Limits {
    standing_ns: 300 * MS,
    stale_ns: 200 * MS,
    silent_ns: 2000 * MS,
    good: 3,
};
const LIFE: Life = [7, 70];

/// A stage with a clock moved by hand, on which the window says what it is told to.
struct Stage {
    now_ms: i64,
    seq: u64,
    heard_ms: i64,
    is_replay: bool,
    is_ending: bool,
    state: State,
    verdict: Verdict,
}

impl Stage {
    fn new() -> Self {
        Self {
            now_ms: 10_000,
            seq: 0,
            heard_ms: 10_000,
            is_replay: false,
            is_ending: false,
            state: State::default(),
            verdict: Verdict::Waiting,
        }
    }

    /// A stage on which all is well.
    fn good() -> Self {
        let mut stage = Self::new();
        stage.paint(10);
        assert_eq!(stage.verdict, Verdict::Good);
        stage
    }

    fn look(&mut self, after_ms: i64, seen: Seen) -> Verdict {
        self.now_ms += after_ms;
        let reading = Reading {
            seen,
            t_session_ns: self.now_ms * MS,
            is_replay: self.is_replay,
            t_heard_ns: Some(self.heard_ms * MS),
            is_ending: self.is_ending,
        };
        (self.state, self.verdict) = step(&LIMITS, self.state, &reading, self.now_ms * MS);
        self.verdict
    }

    fn code(&self, age_ms: i64, shown: Shown) -> Code {
        Code::new(self.seq, (self.now_ms + 50 - age_ms) * MS, shown)
    }

    /// So many looks with a new live picture each, and a sign of life.
    fn paint(&mut self, looks: u32) {
        for _ in 0..looks {
            self.seq += 1;
            self.heard_ms = self.now_ms + 50;
            let code = self.code(20, Shown::Live);
            self.look(50, Seen::Code(LIFE, code));
        }
    }

    /// Looks every 50 ms until the verdict is bad; returns the fault and how long that took, ms.
    fn until_bad(&mut self, mut seen: impl FnMut(&mut Self) -> Seen) -> (Fault, i64) {
        let began_ms = self.now_ms;
        for _ in 0..100 {
            let seen = seen(self);
            if let Verdict::Bad(fault, _) = self.look(50, seen) {
                return (fault, self.now_ms - began_ms);
            }
        }
        panic!("never bad: {:?}", self.state);
    }
}

#[test]
fn a_picture_that_stands_still_is_found_in_one_look_beyond_the_limit() {
    let mut stage = Stage::good();
    let last = Code::new(stage.seq, stage.now_ms * MS, Shown::NotLive);
    assert_eq!(stage.until_bad(|_| Seen::Code(LIFE, last)), (Fault::Standing, 350));
}

/// A live picture that stands is found no later by its age than by its standing.
#[test]
fn a_live_picture_that_stands_is_called_frozen() {
    let mut stage = Stage::good();
    let last = stage.state.newest.unwrap();
    assert_eq!(stage.until_bad(|_| Seen::Code(LIFE, last.1)), (Fault::Standing, 350));
}

#[test]
fn pictures_that_were_there_before_prove_nothing() {
    let mut stage = Stage::good();
    let turns = [stage.seq, stage.seq - 1].map(|seq| Code::new(seq, stage.now_ms * MS, Shown::NotLive));
    let mut turn = 0;
    let found = stage.until_bad(|_| {
        turn += 1;
        Seen::Code(LIFE, turns[turn % 2])
    });
    assert_eq!(found, (Fault::Standing, 350));
}

#[test]
fn a_lively_picture_of_an_old_pose_is_found_by_the_age_it_carries() {
    let mut stage = Stage::good();
    let captured = stage.now_ms * MS;
    let (fault, after_ms) = stage.until_bad(|stage| {
        (stage.seq, stage.heard_ms) = (stage.seq + 1, stage.now_ms + 50);
        Seen::Code(LIFE, Code::new(stage.seq, captured, Shown::Live))
    });
    // 350 ms are tolerated; one more look.
    assert_eq!((fault, after_ms), (Fault::Old, 400));
    // The same pose under a picture that says itself that it is old is no fault.
    for _ in 0..20 {
        (stage.seq, stage.heard_ms) = (stage.seq + 1, stage.now_ms + 50);
        stage.look(50, Seen::Code(LIFE, Code::new(stage.seq, captured, Shown::NotLive)));
    }
    assert_eq!(stage.verdict, Verdict::Good);
}

#[test]
fn whatever_keeps_the_cell_away_is_named() {
    for why in [
        Unread::Grey,
        Unread::CheckSum,
        Unread::Size,
        Unread::Frame,
        Unread::Version,
    ] {
        assert_eq!(
            Stage::good().until_bad(|_| Seen::Unread(why)),
            (Fault::Unread(why), 350)
        );
    }
    assert_eq!(Stage::good().until_bad(|_| Seen::NoWindow), (Fault::NoWindow, 350));
}

/// A torn read now and then is what a screen without a common beat gives.
#[test]
fn a_torn_read_between_good_ones_is_no_fault() {
    let mut stage = Stage::good();
    for _ in 0..50 {
        stage.look(50, Seen::Unread(Unread::CheckSum));
        stage.look(50, Seen::Unread(Unread::Grey));
        stage.paint(1);
        assert_eq!(stage.verdict, Verdict::Good);
    }
}

#[test]
fn a_cover_is_lifted_by_three_newer_pictures_and_by_nothing_less() {
    let mut stage = Stage::good();
    stage.until_bad(|_| Seen::Unread(Unread::Grey));
    stage.paint(2);
    assert!(matches!(stage.verdict, Verdict::Bad(Fault::Unread(_), _)));
    // Too long without a newer one, and they are counted from the first again.
    for _ in 0..7 {
        stage.look(50, Seen::Unread(Unread::Grey));
    }
    stage.paint(1);
    stage.look(50, Seen::Unread(Unread::CheckSum));
    stage.paint(1);
    assert!(matches!(stage.verdict, Verdict::Bad(Fault::Unread(_), _)));
    stage.paint(1);
    assert_eq!(stage.verdict, Verdict::Good);
}

#[test]
fn a_new_life_may_count_from_anywhere_and_its_first_picture_proves_nothing() {
    let mut stage = Stage::good();
    stage.until_bad(|_| Seen::NoWindow);
    let other = [7, 71];
    for seq in 0..4 {
        assert!(matches!(stage.verdict, Verdict::Bad(..)), "{seq}");
        stage.heard_ms = stage.now_ms + 50;
        let code = Code::new(seq, (stage.now_ms + 40) * MS, Shown::Live);
        stage.look(50, Seen::Code(other, code));
    }
    assert_eq!(stage.verdict, Verdict::Good);
}

#[test]
fn a_window_without_signs_of_life_and_one_of_a_time_to_come_are_faults() {
    let mut stage = Stage::good();
    let found = stage.until_bad(|stage| {
        stage.seq += 1;
        Seen::Code(LIFE, stage.code(20, Shown::Live))
    });
    assert_eq!(found, (Fault::Silent, 2050));
    let mut stage = Stage::good();
    let ahead = Code::new(stage.seq + 1, (stage.now_ms + 1000) * MS, Shown::Live);
    assert_eq!(stage.until_bad(|_| Seen::Code(LIFE, ahead)), (Fault::Ahead, 50));
}

#[test]
fn nothing_is_live_in_a_replay() {
    let mut stage = Stage::new();
    stage.is_replay = true;
    for _ in 0..20 {
        (stage.seq, stage.heard_ms) = (stage.seq + 1, stage.now_ms + 50);
        let code = stage.code(1_000_000, Shown::Replay);
        stage.look(50, Seen::Code(LIFE, code));
    }
    assert_eq!(stage.verdict, Verdict::Good);
    stage.paint(1);
    assert!(matches!(stage.verdict, Verdict::Bad(Fault::LiveInReplay, _)));
}

#[test]
fn who_was_never_there_and_who_was_told_to_go_are_not_missed() {
    let mut stage = Stage::new();
    assert_eq!(stage.look(60_000, Seen::NoWindow), Verdict::Waiting);
    // A watcher that is started beside a window that hangs has its limit to find out.
    let standing = stage.code(0, Shown::Nothing);
    assert_eq!(stage.until_bad(|_| Seen::Code(LIFE, standing)).0, Fault::Standing);
    let mut stage = Stage::good();
    stage.is_ending = true;
    assert_eq!(stage.look(50, Seen::NoWindow), Verdict::Closed);
    assert_eq!(stage.look(50_000, Seen::NoWindow), Verdict::Closed);
    // It said so and stayed: its picture is judged like any other.
    let mut stage = Stage::good();
    stage.is_ending = true;
    let last = stage.state.newest.unwrap();
    assert_eq!(stage.until_bad(|_| Seen::Code(LIFE, last.1)).0, Fault::Standing);
}

fn seen() -> impl Strategy<Value = Seen> {
    let code = (0_u64..6, -2000_i64..2000, prop::bool::ANY, prop::bool::ANY).prop_map(|(seq, t, live, life)| {
        let shown = if live { Shown::Live } else { Shown::NotLive };
        Seen::Code([7, u32::from(life)], Code::new(seq, (10_000 + t) * MS, shown))
    });
    prop_oneof![Just(Seen::NoWindow), Just(Seen::Unread(Unread::Grey)), code]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever is on the screen, what is called good rests on a newer code within the limit, and what says live is young.
    #[test]
    fn what_is_good_was_proven_within_the_limit(looks in prop::collection::vec((1_i64..400, seen()), 1..60)) {
        let mut stage = Stage::new();
        // The oracle keeps all codes of a life and believes only what is newer than each of them.
        let (mut codes, mut proven_ms, mut alive): (Vec<Code>, Option<i64>, Option<Life>) = (Vec::new(), None, None);
        for (after, seen) in looks {
            stage.heard_ms = stage.now_ms + after;
            let verdict = stage.look(after, seen);
            if let Seen::Code(life, code) = seen {
                if alive != Some(life) {
                    (codes, alive) = (vec![code], Some(life));
                } else if codes.iter().all(|old| code.is_behind(*old)) {
                    codes.push(code);
                    proven_ms = Some(stage.now_ms);
                }
            }
            if seen != Seen::NoWindow {
                proven_ms = proven_ms.or(Some(stage.now_ms));
            }
            if verdict == Verdict::Good {
                prop_assert!(stage.now_ms - proven_ms.unwrap() <= 300);
                if let Seen::Code(_, code) = seen && code.shown() == Shown::Live {
                    prop_assert!((-300..=500).contains(&code.age_ms(stage.now_ms * MS)));
                }
            }
            if verdict == Verdict::Waiting {
                prop_assert_eq!(proven_ms, None);
            }
        }
    }

    /// A window that paints at least every 250 ms what is young is never covered, however the looks fall.
    #[test]
    fn a_window_that_paints_in_time_is_never_covered(gaps in prop::collection::vec((10_i64..250, 1_i64..50), 1..80)) {
        let mut stage = Stage::new();
        for (gap, look) in gaps {
            // Looks between two pictures see the same one.
            stage.seq += 1;
            let painted = stage.code(20, Shown::Live);
            let mut left = gap;
            while left > 0 {
                let after = look.min(left);
                stage.heard_ms = stage.now_ms + after;
                stage.look(after, Seen::Code(LIFE, painted));
                prop_assert_eq!(stage.verdict, Verdict::Good);
                left -= after;
            }
        }
    }
}
