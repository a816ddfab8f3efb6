//! What a person chose, how far the run came, and what happened to its processes.

use std::collections::BTreeMap;

use bus::message::{self, Workflow};
use serde::Serialize;

use super::navigated::Navigated;
use super::short::{List, short};
use super::stage_times::StageTimes;
use crate::wire::proto::{Log, ProcessStatus};

/// More processes are none of a run's.
const MOST_PROCESSES: usize = 64;
/// In front of the words of a mark.
const MARK: &str = "mark: ";
/// In front of the pilot's words that a run is being ended.
const ENDING: &str = "ending: ";
/// In front of those on a check of the registration, and what it came to.
const CHECK: &str = "check ";
const VERDICTS: [&str; 3] = ["passed", "FAILED", "does not hold"];
/// The word for a stage of a later version.
const UNKNOWN_STAGE: &str = "unknown stage";
/// Who says all three.
const PILOT: &str = "pilot";

/// What was aimed at, and held, from a moment on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Choice {
    /// When it was said, ns since the run's epoch.
    pub(super) t_ns: i64,
    /// `None`: nothing was aimed at.
    pub(super) target: Option<Target>,
    /// The number of the pose that was held.
    pub(super) held_seq: Option<u64>,
}

/// A target.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Target {
    pub(super) name: String,
    /// The plan's id, 16 hexadecimal digits.
    pub(super) plan_id: String,
    /// LPS, mm.
    pub(super) centre_mm: [f64; 3],
    pub(super) radius_mm: f64,
    /// LPS, mm.
    pub(super) entry_mm: Option<[f64; 3]>,
    pub(super) stop_mm: f64,
}

/// How far the run was from a moment on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Stage {
    /// ns since the run's epoch.
    pub(super) t_ns: i64,
    /// The stage's word; that of one that is not known says so.
    pub(super) stage: String,
    /// RESEARCH, NOT CHECKED and so on.
    pub(super) marks: Vec<&'static str>,
    /// See [`Workflow::flags`].
    pub(super) flags: u32,
}

/// A process that was started anew.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Restart {
    /// When the new one said something first, ns since the run's epoch.
    pub(super) t_ns: i64,
    pub(super) process: String,
    /// The numbers of the old one and of the new one.
    pub(super) pids: (u32, u32),
}

/// What a process said last of what it had done.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Last {
    /// ns since the run's epoch.
    pub(super) t_ns: i64,
    pub(super) state: String,
    pub(super) note: String,
    pub(super) published: u64,
    pub(super) lost: u64,
    pub(super) dropped: u64,
    pub(super) refused: u64,
    #[serde(skip)]
    pid: u32,
}

/// A line of the log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Line {
    /// ns since the run's epoch.
    pub(super) t_ns: i64,
    /// `warning` or `error`.
    pub(super) level: &'static str,
    pub(super) who: String,
    pub(super) words: String,
}

/// Known points were touched, and the registration held against them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Check {
    /// When it was told, ns since the run's epoch.
    pub(super) t_ns: i64,
    /// The registration that poses rested on then, 16 hexadecimal digits: the pilot takes no check of another. `None`: there was no
    /// pose before.
    pub(super) registration: Option<String>,
    #[serde(flatten)]
    pub(super) said: CheckSaid,
}

/// What the pilot says of a check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct CheckSaid {
    /// `passed`, `FAILED` or `does not hold`: too old when it was told, or the marker on the patient was moved.
    pub(super) verdict: &'static str,
    /// How many points were touched.
    pub(super) points: u32,
    /// The largest distance of one of them from its place, mm.
    pub(super) worst_mm: f64,
    /// The point that is further off than its registration promises, with both distances; empty where none is.
    pub(super) because: String,
}

/// What a line of the log means for the report.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Meaning {
    /// A person marked the moment with these words.
    Mark(String),
    /// The run is being ended.
    Ending,
    /// The registration was checked.
    Check(CheckSaid),
    /// Nothing more than it says.
    Line,
}

/// All of it.
#[derive(Debug, Default, Serialize)]
pub(super) struct Story {
    /// Where it changed.
    pub(super) choices: List<Choice>,
    /// Where it changed.
    pub(super) stages: List<Stage>,
    /// Of the registration.
    pub(super) checks: List<Check>,
    pub(super) restarts: List<Restart>,
    /// By the process's name.
    pub(super) processes: BTreeMap<String, Last>,
    /// Warnings and errors.
    pub(super) lines: List<Line>,
    /// Lines of the log that say what is as it should be.
    pub(super) plain_lines: u64,
    #[serde(skip)]
    newest: (Option<Choice>, Option<Stage>),
    #[serde(skip)]
    pub(super) navigated: Navigated,
    /// Confirmations could be skipped, at whatever stage.
    #[serde(skip)]
    pub(super) is_research: bool,
    #[serde(skip)]
    pub(super) stage_times: StageTimes,
}

impl Story {
    /// What a person chose.
    pub(super) fn guide(&mut self, guide: &message::Guide) {
        let chosen = guide.chosen().ok().flatten();
        let choice = Choice {
            t_ns: guide.t_ns,
            target: chosen.map(|chosen| Target {
                name: short(&chosen.name),
                plan_id: format!("{:016x}", guide.plan_id),
                centre_mm: chosen.centre.mm(),
                radius_mm: chosen.radius_mm,
                entry_mm: chosen.entry.map(geometry::Point::mm),
                stop_mm: chosen.stop_mm,
            }),
            held_seq: guide.held().map(|held| held.seq),
        };
        // Said again where a file begins.
        let is_news = |last: &Choice| (&last.target, last.held_seq) != (&choice.target, choice.held_seq);
        if self.newest.0.as_ref().is_none_or(is_news) {
            self.newest.0 = Some(choice.clone());
            self.choices.push(choice);
        }
    }

    /// How far the run has come, written down at `t_ns`.
    pub(super) fn workflow(&mut self, t_ns: i64, workflow: Workflow) {
        self.navigated.take(&workflow);
        self.is_research |= workflow.has(Workflow::RESEARCH);
        let stage = Stage {
            t_ns,
            stage: workflow.stage().map_or(UNKNOWN_STAGE, |stage| stage.word()).to_owned(),
            marks: marks(&workflow),
            flags: workflow.flags,
        };
        let is_news = |last: &Stage| (&last.stage, last.flags) != (&stage.stage, stage.flags);
        if self.newest.1.as_ref().is_none_or(is_news) {
            self.stage_times.begins(t_ns, &stage.stage);
            self.newest.1 = Some(stage.clone());
            self.stages.push(stage);
        }
    }

    /// A sign of life.
    pub(super) fn status(&mut self, status: &ProcessStatus) {
        let process = short(&status.process);
        if self.processes.len() == MOST_PROCESSES && !self.processes.contains_key(&process) {
            return;
        }
        let last = Last {
            t_ns: status.t_ns,
            state: short(&status.state),
            note: short(&status.note),
            published: status.published,
            lost: status.lost,
            dropped: status.dropped,
            refused: status.refused,
            pid: status.pid,
        };
        let before = self.processes.insert(process.clone(), last);
        if let Some(before) = before.filter(|before| before.pid != status.pid) {
            self.restarts.push(Restart {
                t_ns: status.t_ns,
                process,
                pids: (before.pid, status.pid),
            });
        }
    }

    /// A line of the log, written at `t_ns`.
    pub(super) fn log(&mut self, t_ns: i64, log: &Log) -> Meaning {
        let level = match log.level {
            3 => "warning",
            level if level > 3 => "error",
            _ => {
                self.plain_lines += 1;
                return meaning(log);
            }
        };
        self.lines.push(Line {
            t_ns,
            level,
            who: short(&log.name),
            words: short(&log.message),
        });
        Meaning::Line
    }
}

fn meaning(log: &Log) -> Meaning {
    if log.name != PILOT {
        return Meaning::Line;
    }
    match log.message.strip_prefix(MARK) {
        Some(words) => Meaning::Mark(short(words)),
        None if log.message.starts_with(ENDING) => Meaning::Ending,
        None => check(&log.message).map_or(Meaning::Line, Meaning::Check),
    }
}

/// What the pilot's words on a check say (`check passed: 3 points, the worst 1.50 mm off`, with a reason in brackets behind); `None`
/// for other words.
fn check(words: &str) -> Option<CheckSaid> {
    let (verdict, rest) = words.strip_prefix(CHECK)?.split_once(": ")?;
    let verdict = VERDICTS.into_iter().find(|known| *known == verdict)?;
    let (points, rest) = rest.split_once(" points, the worst ")?;
    let (worst_mm, because) = rest.split_once(" mm off")?;
    let worst_mm = worst_mm.parse().ok().filter(|mm: &f64| mm.is_finite())?;
    // Nothing passes by no point.
    let points = points
        .parse()
        .ok()
        .filter(|points| *points > 0 || verdict != VERDICTS[0])?;
    // A long reason comes without its end.
    let because = because.trim_start_matches(" (");
    Some(CheckSaid {
        verdict,
        points,
        worst_mm,
        because: short(because.strip_suffix(')').unwrap_or(because)),
    })
}

/// What a person had to know of a stage.
fn marks(workflow: &Workflow) -> Vec<&'static str> {
    let words = [
        (Workflow::SIGHT, "sight allowed"),
        (Workflow::RESEARCH, "RESEARCH"),
        (Workflow::CONFIRMED, "identity confirmed"),
        (Workflow::REJECTED, "IDENTITY REJECTED"),
        (Workflow::CHECK_FAILED, "CHECK FAILED"),
        (Workflow::BUMPED, "MARKER ON THE PATIENT PUSHED"),
    ];
    let said = words
        .into_iter()
        .filter(|(flag, _)| workflow.has(*flag))
        .map(|(_, words)| words);
    said.chain(workflow.marks().iter().map(|mark| mark.word())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::Level;

    #[test]
    fn only_the_pilot_marks_and_ends() {
        let mut story = Story::default();
        let mut said = |level, name: &str, words: &str| story.log(0, &Log::new(0, level, name, words.to_owned()));
        assert_eq!(
            said(Level::Info, "pilot", "mark: biopsy"),
            Meaning::Mark("biopsy".to_owned())
        );
        assert_eq!(
            said(Level::Info, "pilot", "ending: the pictures show pose 3"),
            Meaning::Ending
        );
        assert_eq!(said(Level::Info, "tracker", "mark: biopsy"), Meaning::Line);
        assert_eq!(said(Level::Error, "pilot", "mark: biopsy"), Meaning::Line);
        assert_eq!((story.lines.count, story.plain_lines), (1, 3));
    }

    /// Checks stood among the lines of the log alone.
    #[test]
    fn what_the_pilot_says_of_a_check_is_taken_apart() {
        let said = |words: &str| meaning(&Log::new(0, Level::Info, "pilot", words.to_owned()));
        let check = |verdict, points, worst_mm, because: &str| {
            Meaning::Check(CheckSaid {
                verdict,
                points,
                worst_mm,
                because: because.to_owned(),
            })
        };
        // As `pilot/src/guiding/progress.rs` says it, and its tests hold.
        for (words, expected) in [
            (
                "check passed: 3 points, the worst 1.50 mm off",
                check("passed", 3, 1.5, ""),
            ),
            (
                "check FAILED: 1 points, the worst 5.25 mm off (nasion (left): 5.25 mm off, 2.10 mm hold 95 % of errors)",
                check(
                    "FAILED",
                    1,
                    5.25,
                    "nasion (left): 5.25 mm off, 2.10 mm hold 95 % of errors",
                ),
            ),
            (
                "check does not hold: 3 points, the worst 0.40 mm off",
                check("does not hold", 3, 0.4, ""),
            ),
        ] {
            assert_eq!(said(words), expected, "{words}");
        }
        for words in [
            "check passed",
            "check perfect: 3 points, the worst 1.50 mm off",
            "check passed: 0 points, the worst 0.00 mm off",
            "check passed: many points, the worst 1.50 mm off",
            "check passed: 3 points, the worst NaN mm off",
        ] {
            assert_eq!(said(words), Meaning::Line, "{words}");
        }
    }

    #[test]
    fn a_process_of_another_number_was_started_anew() {
        let mut story = Story::default();
        let beat = |process: &str, pid, t_ns| ProcessStatus {
            t_ns,
            process: process.to_owned(),
            pid,
            ..ProcessStatus::default()
        };
        for status in [
            beat("tracker", 7, 1),
            beat("tracker", 7, 2),
            beat("loader", 8, 3),
            beat("tracker", 9, 4),
        ] {
            story.status(&status);
        }
        let restarts: Vec<_> = story
            .restarts
            .listed
            .iter()
            .map(|r| (r.t_ns, r.process.as_str(), r.pids))
            .collect();
        assert_eq!(restarts, [(4, "tracker", (7, 9))]);
    }

    #[test]
    fn what_is_said_again_is_no_news() {
        let mut story = Story::default();
        let mut guide = message::Guide::default();
        story.guide(&guide);
        guide.t_ns = 9;
        story.guide(&guide);
        assert_eq!(story.choices.count, 1);
        let flags = Workflow::NOT_CHECKED | Workflow::RESEARCH;
        let workflow = Workflow {
            t_ns: 0,
            stage: 4,
            flags,
            ..Workflow::default()
        };
        let later = Workflow {
            t_ns: 0,
            stage: 77,
            flags: 0,
            ..Workflow::default()
        };
        for (t_ns, workflow) in [(10, workflow), (20, workflow), (30, later), (25, workflow)] {
            story.workflow(t_ns, workflow);
        }
        let marks = vec!["RESEARCH", "NOT CHECKED"];
        let stages: Vec<_> = story
            .stages
            .listed
            .iter()
            .map(|s| (s.stage.as_str(), s.marks.clone()))
            .collect();
        assert_eq!(
            stages,
            [
                ("REGISTERED", marks.clone()),
                (UNKNOWN_STAGE, vec![]),
                ("REGISTERED", marks)
            ]
        );
        let times = story.stage_times.finish(5, 100);
        let expected = [("not told", 5), ("REGISTERED", 90)].map(|(word, ns)| (word.to_owned(), ns));
        assert_eq!(times, expected, "the stage that was told late has no time");
    }
}
