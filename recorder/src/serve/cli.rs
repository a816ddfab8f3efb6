//! `recorder serve`.

use std::net::SocketAddr;
use std::time::Duration;

use clap::Args;

pub(crate) const SERVE_HELP: &str = "\
Foxglove (desktop or in a browser on this machine) connects to ws://localhost:8765 and shows poses, states, the log, small images and \
a scene of tool, targets and planes: the topics of a recording, live. Each image and the scene say RESEARCH DISPLAY and the time of day: what \
is shown may be late or lost on its way. The tool is drawn only as long as an image of the run may claim its pose and the run's workflow lets it \
be shown. Nothing of a client comes back into the run, and whose examination it is goes to no client.

Examples:
  recorder serve --foxglove
  recorder serve --foxglove --run demo --every 100ms";

/// Which run, and to whom.
#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// Serve Foxglove's WebSocket protocol
    #[arg(long, required = true)]
    foxglove: bool,
    /// The run
    #[arg(long, value_name = "NAME", default_value = "default")]
    pub(super) run: String,
    /// An address of this machine's own, and the port
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:8765")]
    pub(super) listen: SocketAddr,
    /// Between two images of a view, 20 ms to 10 s; one view at a time
    #[arg(long, value_name = "TIME", default_value = "200ms", value_parser = interval)]
    pub(super) every: Duration,
}

/// `200ms` or `1.5s`.
fn interval(text: &str) -> Result<Duration, String> {
    let (number, unit_s) = match text.strip_suffix("ms") {
        Some(number) => (number, 1e-3),
        None => (text.strip_suffix('s').unwrap_or(""), 1.0),
    };
    let seconds: Option<f64> = number.parse().ok().map(|number: f64| number * unit_s);
    match seconds.filter(|seconds| (0.02..=10.0).contains(seconds)) {
        Some(seconds) => Ok(Duration::from_secs_f64(seconds)),
        None => Err("expected a time such as 200ms or 1s, from 20ms to 10s".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::interval;
    use std::time::Duration;

    #[test]
    fn times_have_a_unit_and_bounds() {
        assert_eq!(interval("200ms"), Ok(Duration::from_millis(200)));
        assert_eq!(interval("1.5s"), Ok(Duration::from_millis(1500)));
        for wrong in ["", "200", "ms", "19ms", "11s", "-1s", "nans", "infs"] {
            assert!(interval(wrong).is_err(), "{wrong}");
        }
    }
}
