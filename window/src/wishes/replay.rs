//! What a person wishes of a replay.

use bus::clock;
use bus::message::{ClockLaw, Command, CommandKind, ReplayState};
use bus::port::{CommandClient, Pending};

use crate::model::{ReplayModel, at_ns};
use crate::screen::Wish;

/// How fast a recording is gone through by its keys.
const SPEEDS: [f64; 8] = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// Whoever replays, and where it is to go: one place at a time, the newest that was pointed at.
#[derive(Debug)]
pub(super) struct Replayer {
    client: CommandClient,
    wanted_s: Option<f64>,
    going: Option<Pending>,
}

impl Replayer {
    pub(super) const fn new(client: CommandClient) -> Self {
        Self {
            client,
            wanted_s: None,
            going: None,
        }
    }

    pub(super) const fn client(&self) -> &CommandClient {
        &self.client
    }

    /// Goes to this place once it has got to the one before, and to none in between.
    pub(super) fn seek(&mut self, to_s: f64) -> Result<(), String> {
        self.wanted_s = Some(to_s);
        self.go_on()
    }

    /// Takes in the answer to the last place.
    pub(super) fn hear(&mut self, patience_ns: i64) -> Result<(), String> {
        let Some(going) = &self.going else { return Ok(()) };
        let heard = match going.reply() {
            Ok(None) if going.waited_ns() <= patience_ns => return Ok(()),
            Ok(None) => Err(going.no_answer().to_string()),
            Ok(Some(reply)) if reply.refused => Err(reply.text),
            Ok(Some(_)) => Ok(()),
            Err(error) => Err(error.to_string()),
        };
        self.going = None;
        heard.and(self.go_on())
    }

    fn go_on(&mut self) -> Result<(), String> {
        if self.going.is_some() {
            return Ok(());
        }
        let Some(to_s) = self.wanted_s.take() else {
            return Ok(());
        };
        self.going = Some(super::send(
            &self.client,
            Command::with_number(CommandKind::Seek, to_s),
        )?);
        Ok(())
    }
}

/// What is asked of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Steering {
    /// A request without a number.
    Plain(CommandKind),
    /// Another speed.
    Speed(f64),
    /// Another place, seconds.
    Seek(f64),
}

/// What the replayer is asked for, where its clock is `law` and shows `now_ns`; `None` for a wish of another kind.
///
/// # Errors
/// In words: that there is no such place.
pub(super) fn steering(
    wish: &Wish,
    (law, now_ns): (&ClockLaw, i64),
    replay: Option<&ReplayModel>,
) -> Option<Result<Steering, String>> {
    let place_s = |t_ns: i64| clock::ms(t_ns.saturating_sub(law.zero_ns)) / 1000.0;
    let [first_s, last_s] = [law.first_ns, law.last_ns].map(place_s);
    let goes = |to_s: f64| Ok(Steering::Seek(to_s.clamp(first_s, last_s.max(first_s))));
    let does = |kind| Ok(Steering::Plain(kind));
    Some(match wish {
        Wish::Pause => does(match law.replay_state() {
            ReplayState::Paused => CommandKind::Play,
            ReplayState::Playing => CommandKind::Pause,
            // What has ended begins anew.
            ReplayState::Ended => return Some(goes(first_s)),
        }),
        Wish::OnePose => does(CommandKind::Step),
        Wish::PoseBefore => does(CommandKind::StepBack),
        Wish::Moment => does(CommandKind::Moment),
        Wish::Skip(by_s) => goes(place_s(at_ns(law, now_ns)) + f64::from(*by_s)),
        Wish::Seek(t_ns) => goes(place_s(*t_ns)),
        Wish::NextMark { is_forward } => match replay.and_then(|replay| replay.mark_ns(*is_forward)) {
            Some(t_ns) => goes(place_s(t_ns)),
            None => Err(no_mark(replay, *is_forward)),
        },
        Wish::Speed { is_faster } => match speed(law.speed, *is_faster) {
            Some(speed) => Ok(Steering::Speed(speed)),
            None => Err("there is no such speed".to_owned()),
        },
        _ => return None,
    })
}

fn no_mark(replay: Option<&ReplayModel>, is_forward: bool) -> String {
    let told = replay.and_then(|replay| replay.timeline.as_ref());
    let so_far = match told {
        Some(told) if told.is_read() && told.marks_left_out == 0 => "",
        Some(told) if told.is_read() => " among those that the bar has room for",
        _ => " as far as the recording was read",
    };
    let where_to = if is_forward {
        "behind this place"
    } else {
        "before this place"
    };
    format!("there is no mark {where_to}{so_far}")
}

/// The next speed of the list.
fn speed(now: f64, is_faster: bool) -> Option<f64> {
    match is_faster {
        true => SPEEDS.into_iter().find(|speed| *speed > now * 1.001),
        false => SPEEDS.into_iter().rfind(|speed| *speed < now * 0.999),
    }
}

#[cfg(test)]
mod tests {
    use std::rc::Rc;

    use bus::message::Timeline;

    use super::*;

    fn law(state: ReplayState) -> ClockLaw {
        ClockLaw {
            first_ns: 12_000_000_000,
            last_ns: 20_000_000_000,
            zero_ns: 10_000_000_000,
            speed: 1.0,
            state: state.code(),
            ..ClockLaw::default()
        }
    }

    fn asked(wish: &Wish, now_ns: i64, state: ReplayState) -> Result<Steering, String> {
        steering(wish, (&law(state), now_ns), None).unwrap()
    }

    /// A replay that was begun at 2 s was sent 2 s too far back.
    #[test]
    fn places_count_from_the_recordings_first_pose_wherever_the_replay_began() {
        let to = |wish: &Wish, now_ns| match asked(wish, now_ns, ReplayState::Playing) {
            Ok(Steering::Seek(to_s)) => to_s,
            other => panic!("{other:?}"),
        };
        assert_eq!(to(&Wish::Skip(5), 13_000_000_000), 8.0);
        // No further than what is replayed; also where the clock has run on behind the end.
        assert_eq!(to(&Wish::Skip(-5), 13_000_000_000), 2.0);
        assert_eq!(to(&Wish::Skip(5), 99_000_000_000), 10.0);
        assert_eq!(to(&Wish::Skip(-5), 99_000_000_000), 5.0);
        assert_eq!(to(&Wish::Seek(15_500_000_000), 0), 5.5);
    }

    #[test]
    fn a_replay_that_has_ended_begins_anew() {
        let pause = |state| asked(&Wish::Pause, 0, state).unwrap();
        let does = Steering::Plain;
        assert_eq!(pause(ReplayState::Playing), does(CommandKind::Pause));
        assert_eq!(pause(ReplayState::Paused), does(CommandKind::Play));
        assert_eq!(pause(ReplayState::Ended), Steering::Seek(2.0));
        assert!(steering(&Wish::Mark, (&law(ReplayState::Playing), 0), None).is_none());
        let why = asked(&Wish::NextMark { is_forward: true }, 0, ReplayState::Paused).unwrap_err();
        assert!(why.contains("as far as the recording was read"), "{why}");
    }

    /// Of 304 marks 64 have room on the bar: behind the last of these there was said to be none.
    #[test]
    fn marks_that_have_no_room_are_not_said_to_be_none() {
        let why = |marks_left_out: u32| {
            let told = Timeline {
                read_bytes: 9,
                bytes: 9,
                marks_left_out,
                ..Timeline::default()
            };
            let replay = ReplayModel {
                span_ns: [0, 9],
                zero_ns: 0,
                at_ns: 5,
                state: ReplayState::Paused,
                speed: 1.0,
                timeline: Some(Rc::new(told)),
            };
            no_mark(Some(&replay), true)
        };
        assert_eq!(why(0), "there is no mark behind this place");
        assert_eq!(
            why(240),
            "there is no mark behind this place among those that the bar has room for"
        );
    }

    #[test]
    fn speeds_follow_one_another_from_wherever_they_began() {
        assert_eq!((speed(1.0, true), speed(1.0, false)), (Some(2.0), Some(0.5)));
        assert_eq!((speed(0.3, true), speed(0.3, false)), (Some(0.5), Some(0.25)));
        assert_eq!(
            (speed(f64::INFINITY, true), speed(f64::INFINITY, false)),
            (None, Some(16.0))
        );
        assert_eq!((speed(16.0, true), speed(0.1, false)), (None, None));
    }
}
