//! What the cover says.

use super::judge::Fault;

/// What is to be done whatever the fault is.
pub const STOP: &str = "DO NOT NAVIGATE";

/// The fault in a few large words, with how long it has been, seconds.
pub fn headline(fault: Fault, for_ns: i64) -> String {
    let what = match fault {
        Fault::NoWindow => "NO WINDOW",
        Fault::Unread(_) => "DISPLAY NOT READABLE",
        Fault::Standing => "DISPLAY FROZEN",
        Fault::Old => "IMAGES OLD",
        Fault::Ahead | Fault::LiveInReplay => "TIME OF IMAGES WRONG",
        Fault::Silent => "WINDOW SILENT",
    };
    // Longer than an hour is no longer counted.
    let seconds = (for_ns as f64 / 1e9).clamp(0.0, 3600.0);
    format!("{what} {seconds:.1} s - {STOP}")
}

/// Why, in a sentence.
pub fn reason(fault: Fault) -> String {
    match fault {
        Fault::NoWindow => "the window has gone; it comes back by itself where it can".to_owned(),
        Fault::Unread(why) => why.to_string(),
        Fault::Standing => "the picture is not painted anew".to_owned(),
        Fault::Old => "the screen says live and shows an old pose".to_owned(),
        Fault::Ahead => "the screen says live and shows a pose of a time to come".to_owned(),
        Fault::LiveInReplay => "the screen says live and this is a replay".to_owned(),
        Fault::Silent => "the window paints and gives no sign of life to the run".to_owned(),
    }
}

/// In one word, for counters and the record of a run.
pub fn name(fault: Fault) -> &'static str {
    match fault {
        Fault::NoWindow => "no-window",
        Fault::Unread(_) => "unread",
        Fault::Standing => "standing",
        Fault::Old => "old",
        Fault::Ahead => "ahead",
        Fault::LiveInReplay => "live-in-replay",
        Fault::Silent => "silent",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_what_for_how_long_and_what_to_do() {
        assert_eq!(
            headline(Fault::Standing, 649_000_000),
            "DISPLAY FROZEN 0.6 s - DO NOT NAVIGATE"
        );
        assert!(headline(Fault::Old, i64::MAX).contains("3600.0 s"));
        assert!(headline(Fault::NoWindow, -1).contains(" 0.0 s"));
    }
}
