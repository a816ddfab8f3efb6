//! The poses of the markers in the localizer's frame, and whether they are young and measured.

use std::collections::VecDeque;

use bus::message::{Lost, MarkerFrame, MarkerSight};

use super::Times;
use crate::tell::Told;

/// As for poses: all processes read one clock.
const FUTURE_NS: i64 = 5_000_000;

/// Frames that are remembered.
const REMEMBERED: usize = 8;
/// Why a marker does not stand beside the tool.
const OTHER: &str = "LOST: seen at another moment than the tool's pose";

/// Follows the frames of the localizer.
#[derive(Debug)]
pub(super) struct Markers {
    frozen_ns: i64,
    last: Option<MarkerFrame>,
    /// What each marker measured last that differed from before, and when.
    measured: [Option<(MarkerSight, i64)>; 2],
    /// Why nothing of the last frame is valid, as told last.
    why_not: Option<&'static str>,
    /// Something came that was not told yet.
    is_new: bool,
    told: Vec<Told>,
    /// What was told of the last frames, with their captures: a pose comes later than the frame that it rests on.
    before: VecDeque<(i64, Vec<Told>)>,
}

impl Markers {
    pub(super) fn new(frozen_ns: i64) -> Self {
        Self {
            frozen_ns,
            last: None,
            measured: [None; 2],
            why_not: None,
            is_new: false,
            told: Vec::new(),
            before: VecDeque::new(),
        }
    }

    /// Takes a frame. One that is older than the last, or of the future, is none.
    pub(super) fn take(&mut self, frame: MarkerFrame, now_ns: i64) {
        let is_older = self.last.is_some_and(|last| frame.t_capture_ns < last.t_capture_ns);
        if is_older || frame.t_capture_ns.saturating_sub(now_ns) > FUTURE_NS {
            return;
        }
        let sights = frame.sights().unwrap_or_default();
        for (marker, measured) in [MarkerFrame::TOOL, MarkerFrame::REFERENCE]
            .into_iter()
            .zip(&mut self.measured)
        {
            let Some(sight) = sights.iter().find(|sight| sight.marker == marker && sight.status == 0) else {
                continue;
            };
            if measured.is_none_or(|(before, _)| (before.q, before.t_mm) != (sight.q, sight.t_mm)) {
                *measured = Some((*sight, frame.t_capture_ns));
            }
        }
        self.last = Some(frame);
        self.is_new = true;
    }

    /// What is to be told at `now_ns`; whether that is news. What is not valid is said again with each beat.
    pub(super) fn step(&mut self, now_ns: i64, times: Times, is_beat: bool) -> bool {
        let age_ns = self.last.map(|last| now_ns.saturating_sub(last.t_capture_ns));
        let why_not = match age_ns {
            None => Some("WAITING: no frame of the localizer has come yet"),
            Some(age) if age > times.stale_ns => Some("STALE: the localizer's last frame is too old"),
            Some(_) => None,
        };
        let is_other = why_not != self.why_not;
        let is_due = self.is_new || is_other || (is_beat && why_not.is_some());
        if !is_due {
            return false;
        }
        (self.why_not, self.is_new) = (why_not, false);
        let frame = self.last.unwrap_or(MarkerFrame::EMPTY);
        let stamp = times.stamp(if why_not.is_some() { now_ns } else { frame.t_capture_ns });
        let until_ns = times.until_ns(frame.t_capture_ns);
        let told = Told::markers(&frame, why_not).into_iter().zip(self.measured);
        let frozen_ns = self.frozen_ns;
        self.told = told
            .map(|(told, measured)| {
                let stands_ns = measured.map_or(0, |(_, since)| frame.t_capture_ns.saturating_sub(since));
                let told = told.at(stamp, until_ns);
                match told.pose {
                    Ok(_) if stands_ns > frozen_ns => Told {
                        pose: Err(format!("LOST: {}", Lost::Frozen.words())),
                        ..told
                    },
                    _ => told,
                }
            })
            .collect();
        if why_not.is_none() {
            self.before.truncate(REMEMBERED - 1);
            self.before.push_front((frame.t_capture_ns, self.told.clone()));
        }
        true
    }

    /// What was told of the frame of this moment; of another's, why it does not stand beside.
    pub(super) fn of_moment(&self, t_capture_ns: i64) -> Vec<Told> {
        let of_it = self.before.iter().find(|(captured, _)| *captured == t_capture_ns);
        of_it.map_or_else(
            || {
                let other = |told: Told| Told {
                    pose: told.pose.and(Err(OTHER.to_owned())),
                    ..told
                };
                self.told().into_iter().map(other).collect()
            },
            |(_, told)| told.clone(),
        )
    }

    /// What was told last.
    pub(super) fn told(&self) -> Vec<Told> {
        self.told.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Marker, Rigid, Vector};

    const MS: i64 = 1_000_000;
    const TIMES: Times = Times {
        epoch_ns: 0,
        stale_ns: 100 * MS,
        is_present: true,
    };

    fn frame(seq: u64, ms: i64, x: f64) -> MarkerFrame {
        let pose = Rigid::<_, Marker>::from_rotation_vector(Vector::new(0.0, 0.1, 0.0), Vector::new(x, 2.0, 3.0));
        let mut frame = MarkerFrame {
            seq,
            t_capture_ns: ms * MS,
            ..MarkerFrame::EMPTY
        };
        let seen = MarkerSight::seen(MarkerFrame::TOOL, pose.unwrap(), 0.1);
        frame
            .set(&[seen, MarkerSight::lost(MarkerFrame::REFERENCE, Lost::OutOfVolume, 0)])
            .unwrap();
        frame
    }

    fn said(markers: &Markers) -> Vec<Result<f32, String>> {
        let told = markers.told();
        told.into_iter()
            .map(|told| told.pose.map(|pose| pose.translation[0]))
            .collect()
    }

    #[test]
    fn each_marker_is_told_as_it_came_or_with_its_reason() {
        let mut markers = Markers::new(500 * MS);
        assert!(markers.step(0, TIMES, true));
        assert!(
            said(&markers)
                .iter()
                .all(|pose| matches!(pose, Err(why) if why.starts_with("WAITING")))
        );
        markers.take(frame(0, 10, 7.0), 10 * MS);
        assert!(markers.step(10 * MS, TIMES, false) && !markers.step(10 * MS, TIMES, true));
        // The localizer's own frame: nothing is turned.
        assert_eq!(
            said(&markers),
            [Ok(7.0), Err("LOST: outside the localizer's view".to_owned())]
        );
    }

    #[test]
    fn tools_of_one_message_are_of_one_moment() {
        let mut markers = Markers::new(500 * MS);
        for (seq, ms) in [(0, 10), (1, 20), (2, 30)] {
            markers.take(frame(seq, ms, ms as f64), ms * MS);
            markers.step(ms * MS, TIMES, false);
        }
        let x = |ms: i64| {
            markers.of_moment(ms * MS)[0]
                .pose
                .clone()
                .map(|pose| pose.translation[0])
        };
        assert_eq!((x(10), x(20), x(30)), (Ok(10.0), Ok(20.0), Ok(30.0)));
        assert_eq!(x(25), Err(OTHER.to_owned()));
        // What has a reason already keeps it.
        assert_eq!(
            markers.of_moment(25 * MS)[1].pose,
            Err("LOST: outside the localizer's view".to_owned())
        );
    }

    #[test]
    fn what_is_old_frozen_late_or_of_the_future_is_not_valid() {
        let mut markers = Markers::new(500 * MS);
        markers.take(frame(0, 10, 7.0), 10 * MS);
        markers.step(10 * MS, TIMES, false);
        assert!(markers.step(111 * MS, TIMES, false));
        assert!(matches!(&said(&markers)[0], Err(why) if why.starts_with("STALE")));
        assert!(markers.step(120 * MS, TIMES, true), "said again");
        for (seq, ms, x) in [(1, 5, 8.0), (2, 500, 9.0)] {
            markers.take(frame(seq, ms, x), 130 * MS);
            assert!(!markers.step(130 * MS, TIMES, false));
        }
        for seq in 3..70 {
            let ms = 10 * seq as i64 + 120;
            markers.take(frame(seq, ms, 7.0), ms * MS);
            markers.step(ms * MS, TIMES, false);
        }
        assert_eq!(said(&markers)[0], Err("LOST: FROZEN MEASUREMENT".to_owned()));
    }
}
