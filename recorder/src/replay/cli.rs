//! The part of the command line that replays.

use std::path::PathBuf;

use bus::process::{Membership, Process};
use clap::Args;

use super::Speed;
use super::process::{NAME, Options, ReplayError, replay};
use super::tape::Delivery;

pub(crate) const REPLAY_HELP: &str = "\
The pilot starts this (`pilot replay FILE`). Moments are ns on the clock of the run that was recorded.

Example:
  recorder replay session.mcap --run-dir /run/user/1000/trocar/replay --span-ns 2500000000 9000000000 --speed 0.25";

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// The recording
    #[arg(value_name = "FILE.mcap")]
    recording: PathBuf,
    /// The run's folder
    #[arg(long, value_name = "DIR")]
    run_dir: PathBuf,
    /// The pilot's process: this one ends with it
    #[arg(long, value_name = "PID")]
    parent: Option<u32>,
    /// Publish what was published from the first of these moments to the second
    #[arg(long, value_names = ["FIRST", "LAST"], num_args = 2, allow_negative_numbers = true, required = true)]
    span_ns: Vec<i64>,
    /// Begin here instead of at the first moment
    #[arg(long, value_name = "MOMENT", allow_negative_numbers = true)]
    begin_ns: Option<i64>,
    /// The zero of the seconds that people name [default: the first moment]
    #[arg(long, value_name = "MOMENT", allow_negative_numbers = true)]
    zero_ns: Option<i64>,
    /// How many times the recording's speed, or `max`: as fast as every view draws every pose
    #[arg(long, default_value = "1")]
    speed: Speed,
    /// Begin anew at the end
    #[arg(long = "loop")]
    looping: bool,
    /// Publish the recorded frames of the localizer in place of the poses: the run's tracker makes those of them again
    #[arg(long, value_name = "KIND", conflicts_with = "looping")]
    frames: Option<Delivery>,
    /// Also in another examination than the recorded one: every image says so
    #[arg(long)]
    force: bool,
    /// Write pictures into this folder; at speed `max`
    #[arg(long, value_name = "DIR")]
    images: Option<PathBuf>,
    /// Pictures of every so many poses
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Write moments that are asked for into this folder
    #[arg(long, value_name = "DIR")]
    moments: Option<PathBuf>,
    /// Read the recording beside the replay and tell what it holds over its time: for a window's bar
    #[arg(long, conflicts_with = "frames")]
    timeline: bool,
    /// Write what came of it, as JSON
    #[arg(long, value_name = "FILE.json")]
    account: Option<PathBuf>,
}

/// Joins the run and replays until asked to stop.
pub(crate) fn run(args: ReplayArgs) -> Result<(), ReplayError> {
    let (run_dir, parent) = (args.run_dir, args.parent);
    let mut process = Process::join(NAME, &Membership { run_dir, parent })?;
    // Two values are required.
    let span_ns = [args.span_ns[0], args.span_ns[1]];
    let options = Options {
        recording: args.recording,
        span_ns,
        begin_ns: args.begin_ns.unwrap_or(span_ns[0]),
        zero_ns: args.zero_ns.unwrap_or(span_ns[0]),
        speed: args.speed,
        looping: args.looping,
        force: args.force,
        frames: args.frames,
        images: args.images.map(|folder| (folder, args.every)),
        moments: args.moments,
        has_timeline: args.timeline,
        account: args.account,
    };
    replay(&mut process, &options)
}
