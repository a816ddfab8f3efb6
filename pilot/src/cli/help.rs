//! What the help of each command says beside its options.

pub(super) const REPLAY_HELP: &str = "\
Every moving image says REPLAY. Pictures written as files are those of the recorded run, byte for byte, on the CPU back \
end, sheet.png too; report.json says that they come from a replay.

Examples:
  pilot replay out/session.mcap                             at the speed of the recording
  pilot replay out/session.mcap --speed 0.25 --from 3.2s --to 9s --loop
  pilot replay out/session.mcap --speed max --headless --images every --out pictures
  pilot replay out/session.mcap --volume /data/ct-17        where the examination lies elsewhere now
  pilot replay out/session.mcap --recompute --calibration tool.json --out again
                                                            what the poses had been with another calibration

Exit codes: as those of `pilot run`.";

pub(super) const REMOTE_HELP: &str = "\
On the other machine `remote-proc send` must run beside the run (docs/remote.md). What is shown is live, with an age that is never \
less than the true one; what is chosen, held and confirmed is so on the other machine. This pilot starts `remote-proc receive`, \
which is built by itself: `cargo xtask remote`.

Examples:
  pilot remote tls/10.0.0.5:7447 --keys keys --window    a second screen
  pilot remote tcp/127.0.0.1:7447 --for 10s --headless   on the same machine, to try it

Exit codes: as those of `pilot run`.";

pub(super) const CONTROL_HELP: &str = "\
Examples:
  pilot replay-control pause
  pilot replay-control step
  pilot replay-control seek 3.2s
  pilot replay-control speed 0.25 --run replay";

pub(super) const RUN_HELP: &str = "\
Examples:
  pilot run --for 10s --out out                        the embedded demonstration
  pilot run scene.toml --out out                       until `pilot stop` or Ctrl-C
  pilot run scene.toml --for 10s --speed max           in simulated time: the same bytes on any machine";

pub(super) const CHECK_HELP: &str = "\
The examination's place, the label map of organs and all files that the scene names are read, and the organs of [tissue] meshed as a run \
meshes them when it starts: seconds for organs of some thousand unknowns, up to minutes for the 150 000 that are allowed. Nothing is started.

Examples:
  pilot check scene.toml
  pilot check scene.toml --quick                       without meshing its organs
  pilot check --volume ct.nii.gz                       the embedded demonstration in another patient";

pub(super) const STATUS_HELP: &str = "\
Examples:
  pilot status
  pilot status --run replay --json";

pub(super) const STOP_HELP: &str = "\
Example:
  pilot stop --run replay";

pub(super) const RESTART_HELP: &str = "\
Examples:
  pilot restart recorder
  pilot restart localizer    also while it is there: it dials anew";

pub(super) const TOPICS_HELP: &str = "\
Example:
  pilot topics";
