//! `pilot calibrate`: the calibrations of a run that is going. They are made by `calib`, which listens to the run.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use crate::cli::error::CliError;
use crate::spawn;

pub(crate) const CALIBRATE_HELP: &str = "\
Starts `calib`, which listens to the emitters of the run beside its tracker; the options are those of the command of \
`calib` of the same name (`pilot calibrate pivot --help` lists them). The scene's gates hold: [tracker.calibration.gates] and \
[tracker.registration.gates]. A file that its [tracker.calibration] or [tracker.registration] names is in use within a second.

Examples:
  pilot calibrate pivot --axis scene --out tool.json      the tip, with the direction that the scene says
  pilot calibrate pivot --out tip.json                    the tip, and then
  pilot calibrate spin --tip tip.json --out axis.json     the shaft, for calib tool
  pilot calibrate tool --pivot tip.json --spin axis.json --out tool.json
  pilot calibrate touch plane --to base.csv               the calibration base: its plane and grooves, and then
  pilot calibrate base base.csv --drawing base.toml --out base.json
  pilot calibrate seat --base base.json --out tool.json   the tool in its seat
  pilot calibrate touch bead-1 --to touched.csv           a point of the patient, and then
  pilot calibrate match beads.json touched.csv --out registration.json
  pilot calibrate register --to-points ct.txt --from-points touched.csv --out registration.json
  pilot calibrate sweep --bone bone.ply --to swept.csv --out registration.json
  pilot calibrate check --known 10,-20,95.5               a known point is touched, and the error held against its prediction

Exit codes: 0 done; 1 refused, and nothing was written.";

/// What is calibrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum What {
    /// The tip: turn the instrument about it.
    Pivot,
    /// The shaft: spin the instrument about it.
    Spin,
    /// A point: hold the tip on it.
    Touch,
    /// The calibration base, from touches of its plane and its grooves.
    Base,
    /// The tool, from the tool in its seat on the base.
    Seat,
    /// The tool, from a tip and a shaft.
    Tool,
    /// The patient, from pairs of points.
    Register,
    /// The patient, from touched points and the beads of the CT.
    Match,
    /// The patient, by gliding over a bone with the tip.
    Sweep,
    /// The registration: hold the tip on a known point.
    Check,
    /// Nothing: prints this. As a value, so that `--help` behind one of the others is that of `calib`.
    #[value(name = "--help", alias = "-h", hide = true)]
    Help,
}

#[derive(Debug, Args)]
pub(crate) struct CalibrateArgs {
    /// What is calibrated.
    #[arg(value_enum, allow_hyphen_values = true)]
    what: What,
    /// Options of `calib`; `--run NAME` names another run than `default`.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "OPTIONS")]
    more: Vec<OsString>,
}

/// Hands over to `calib`; its exit code is the pilot's.
pub(crate) fn calibrate(args: CalibrateArgs) -> Result<ExitCode, CliError> {
    if args.what == What::Help {
        let help = CalibrateArgs::augment_args(clap::Command::new("pilot calibrate"));
        // Where nobody reads stdout any more, there is nobody to tell.
        let _ = help.after_help(CALIBRATE_HELP).print_help();
        return Ok(ExitCode::SUCCESS);
    }
    let status = spawn::hand_over("calib", &arguments(args))?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}

/// The command line of `calib`: in the run `default` unless another is named.
fn arguments(args: CalibrateArgs) -> Vec<OsString> {
    let command = args.what.to_possible_value();
    let command = command.map_or_else(OsString::new, |value| value.get_name().into());
    let named = |option: &OsString| {
        let option = option.to_string_lossy();
        ["--run", "--live"]
            .iter()
            .any(|name| option == *name || option.starts_with(&format!("{name}=")))
    };
    let run = (!args.more.iter().any(named)).then(|| ["--live", "default"].map(OsString::from));
    [command]
        .into_iter()
        .chain(args.more)
        .chain(run.into_iter().flatten())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    #[command(disable_help_flag = true)]
    struct Line {
        #[command(flatten)]
        args: CalibrateArgs,
    }

    #[test]
    fn the_options_are_handed_over_with_a_run() {
        let given = |line: &str| -> Vec<String> {
            let line = Line::parse_from(format!("calibrate {line}").split(' '));
            let words = arguments(line.args);
            words.into_iter().map(|word| word.into_string().unwrap()).collect()
        };
        assert_eq!(
            given("pivot --out a.json --seconds 5"),
            ["pivot", "--out", "a.json", "--seconds", "5", "--live", "default"]
        );
        assert_eq!(
            given("touch bead-1 --run or --to t.csv"),
            ["touch", "bead-1", "--run", "or", "--to", "t.csv"]
        );
        let own = Line::try_parse_from(["calibrate", "--help"]);
        assert!(own.is_ok_and(|line| line.args.what == What::Help));
        // The help of the command itself, and not of the pilot's.
        assert_eq!(given("pivot --help")[..2], ["pivot", "--help"]);
        assert_eq!(
            given("check --live=or --known -1,2,3"),
            ["check", "--live=or", "--known", "-1,2,3"]
        );
    }
}
