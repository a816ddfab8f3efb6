//! What was wrong with a run, in words: whoever reads only the exit code is told by it that there is something to read.

pub(crate) mod missing;

use bus::clock::ms;
use bus::message::{Lost, NOT_RECORDING};
use scene::{Limits, TrackerSource};

use crate::metrics::{Latency, Restart};
use crate::output;
use crate::replay::{self, ReplayReport};
use crate::report::Pictures;
use crate::state::Run;

/// What was wrong with `run`, in words; empty for one that went as it should.
pub(crate) fn problems(run: &Run, pictures: &Pictures) -> Vec<String> {
    let mut problems = pictures.problems.clone();
    problems.extend(run.replay_report().iter().flat_map(ReplayReport::problems));
    problems.extend(run.metrics.poses.problems());
    if run.metrics.frozen() > 0 {
        let (count, frozen_ms) = (run.metrics.frozen(), run.scene.limits.frozen.as_millis());
        problems.push(format!(
            "{count} samples were the same measurement under fresh stamps for more than {frozen_ms} ms: {}",
            Lost::Frozen.words()
        ));
    }
    problems.extend(older(run.metrics.older_ms));
    problems.extend(judgements(run));
    if run.metrics.foreign_volume {
        problems.push("two different examinations were published during this run".to_owned());
    }
    for view in &run.metrics.views {
        if view.unflagged_old > 0 {
            problems.push(format!(
                "{} images older than the limit did not say so",
                view.unflagged_old
            ));
        }
    }
    problems.extend(
        run.metrics
            .tissue
            .report(&run.scene)
            .and_then(|tissue| tissue.problem()),
    );
    problems.extend(run.presence.problem());
    problems.extend(recorder_troubles(run));
    problems.extend(run.crowds.iter().map(ToString::to_string));
    problems.extend(run.cards_given_up.iter().cloned());
    problems.extend(restarted(&run.metrics.restarts));
    problems.extend(
        run.held()
            .map(|name| format!("{name} died too often and was left alone")),
    );
    let unrecorded = pictures
        .processes
        .iter()
        .filter(|process| process.name == "recorder" && process.note.starts_with(NOT_RECORDING));
    problems.extend(unrecorded.map(|process| format!("at its end the session was {}", process.note)));
    let unfinished = output::recordings(&run.options.out, run.options.recording())
        .into_iter()
        .filter(|name| name.ends_with(".recording"));
    problems.extend(unfinished.map(|name| format!("{name} was not finished: `recorder recover` brings it back")));
    problems
}

/// Poses that may have waited in a queue.
fn older(most_ms: u64) -> Option<String> {
    (most_ms > 0).then(|| {
        format!(
            "poses may have been up to {most_ms} ms older than their arrival said: the localizer's clock seemed to be set back, as it does \
             where frames wait in a queue on its side, and nothing told the two apart; they were counted as that old"
        )
    })
}

/// What came while the recorder could not write, of every topic, and how long a disk made it wait.
fn recorder_troubles(run: &Run) -> Vec<String> {
    let Some(i) = run.place_of("recorder") else {
        return Vec::new();
    };
    let longest_ns = run.children[i].standstill.longest_ns;
    let waited = (longest_ns > bus::clock::ns(run.scene.limits.silent)).then(|| {
        let waited_s = ms(longest_ns) / 1e3;
        format!("the recorder's work stood still for {waited_s:.1} s, as for a disk that does not answer")
    });
    run.unrecorded.words().into_iter().chain(waited).collect()
}

/// Processes that ended before the run did, one line each. What a person wanted is no problem.
fn restarted(restarts: &[Restart]) -> Vec<String> {
    let restarts: Vec<&Restart> = restarts
        .iter()
        .filter(|restart| restart.cause != Restart::ASKED)
        .collect();
    let mut names: Vec<&str> = restarts.iter().map(|restart| restart.process.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let of = |name: &str| {
        let its = || restarts.iter().copied().filter(|restart| restart.process == name);
        let last = its().next_back()?;
        let count = times(its().count());
        Some(format!(
            "{name} ended {count} before the run did, last {}",
            last.words()
        ))
    };
    names.into_iter().filter_map(of).collect()
}

/// A count in words.
pub(crate) fn times(count: usize) -> String {
    match count {
        1 => "once".to_owned(),
        _ => format!("{count} times"),
    }
}

/// Of a run that navigated: what it missed, how late it was, and what its recording lacks. A replay shows what is recorded.
fn judgements(run: &Run) -> Vec<String> {
    if run.options.replay.is_some() {
        return Vec::new();
    }
    let limits = &run.scene.limits;
    let mut problems = Vec::new();
    problems.extend(missing::problem(&run.metrics.poses, limits));
    // Simulated time passes at no machine's pace.
    if !run.options.simulated_time {
        let whole = run.metrics.latencies().last();
        problems.extend(whole.and_then(|(_, latency)| late(&latency, limits)));
    }
    if run.simulated_time_stands_still() {
        problems.push("simulated time stood still: somebody never drew, or never took, the last pose".to_owned());
    }
    problems.extend(cut_short(run));
    problems.extend(unrecorded(run));
    problems
}

/// Images that were old when they were first seen.
fn late(whole: &Latency, limits: &Limits) -> Option<String> {
    let most_ms = ms(bus::clock::ns(limits.latency_p99?));
    (whole.p99 > most_ms).then(|| {
        format!(
            "overload: one image in a hundred came more than {:.0} ms after its pose was captured; limits.latency_p99_ms \
             allows {most_ms:.0} ms",
            whole.p99
        )
    })
}

/// A timed run whose tracker never said that its last sample had gone out.
fn cut_short(run: &Run) -> Option<String> {
    let timed = run.options.duration.is_some() && !run.stop.is_set() && !run.asked_to_stop;
    let external = matches!(run.scene.tracker.source, TrackerSource::External);
    let tracked = !external && run.options.remote.is_none();
    let done = run.tracker_is_done || run.replay_has_ended();
    (timed && tracked && !done)
        .then(|| "the tracker did not come to the end of the run's time: the last samples are not there".to_owned())
}

/// Poses that went out and are in none of the session's files.
fn unrecorded(run: &Run) -> Option<String> {
    run.scene.recording.as_ref()?;
    let published = run.metrics.poses.published;
    let files = output::recordings(&run.options.out, run.options.recording());
    let whole = files.iter().filter(|name| name.ends_with(".mcap"));
    let recorded = whole.map(|name| replay::recorded_poses(&run.options.out.join(name)));
    let recorded = recorded.fold(0, u64::saturating_add);
    (recorded < published).then(|| {
        format!(
            "the recording lacks {} of the {published} samples that went out",
            published - recorded
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problems::missing::tests::limits;
    use crate::state::Unrecorded;
    use bus::message::{Counters, Heartbeat, ProcessState};

    /// A disk that was full and had room again once left nothing in the report but a count.
    #[test]
    fn a_time_without_a_recording_is_a_problem_with_its_cause_also_when_it_is_over() {
        let beat = |lost, words| {
            let counters = Counters {
                lost,
                ..Counters::default()
            };
            Heartbeat::new(ProcessState::Ready, 0, counters, words)
        };
        let mut unrecorded = Unrecorded::default();
        unrecorded.heard(&beat(0, "500 on disk, 400 synced"));
        assert_eq!(unrecorded.words(), None);
        unrecorded.heard(&beat(3, "NOT RECORDING, 3 lost: writing session.mcap: no space"));
        unrecorded.heard(&beat(7, "NOT RECORDING, 7 lost: creating session.mcap: no space"));
        unrecorded.heard(&beat(7, "900 on disk, 800 synced"));
        let words = unrecorded.words().unwrap();
        assert!(
            words.contains("counts 7 messages")
                && words.contains("first said: NOT RECORDING, 3 lost: writing session.mcap: no space"),
            "{words}"
        );
    }

    #[test]
    fn every_restart_is_a_problem() {
        let restart = |process: &str, at_s| Restart {
            process: process.to_owned(),
            cause: "killed by signal 9".to_owned(),
            at_s,
            live_again_s: Some(0.2),
            at_ns: 0,
        };
        assert!(restarted(&[]).is_empty());
        let mut asked = restart("localizer", 1.0);
        asked.cause = Restart::ASKED.to_owned();
        assert!(restarted(&[asked]).is_empty());
        let found = restarted(&[
            restart("tracker", 1.0),
            restart("recorder", 2.0),
            restart("tracker", 3.0),
        ]);
        assert_eq!(
            found,
            [
                "recorder ended once before the run did, last at 2.00 s: killed by signal 9",
                "tracker ended 2 times before the run did, last at 3.00 s: killed by signal 9"
            ]
        );
    }

    #[test]
    fn images_later_than_the_limit_are_an_overload() {
        let latency = |p99| Latency {
            p99,
            ..Latency::default()
        };
        // Unless the scene says otherwise, later than an image may be before it is old.
        assert_eq!(late(&latency(100.0), &limits("")), None);
        assert!(late(&latency(101.0), &limits("")).unwrap().contains("101 ms"));
        assert_eq!(late(&latency(101.0), &limits("stale_ms = 200")), None);
        assert!(late(&latency(101.0), &limits("stale_ms = 200\nlatency_p99_ms = 50")).is_some());
        assert_eq!(late(&latency(1e6), &limits("latency_p99_ms = 0")), None);
    }
}
