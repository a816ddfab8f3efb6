//! The page: a table for each dial.

use std::fmt::Write;

use super::dials::{GROUPS, Key};
use super::rows::{Measured, Setting};

/// The line of the page that says where and when its numbers were measured begins with this.
pub(super) const MADE: &str = "Measured ";

const HEAD: &str = "\
<!-- Made by `cargo xtask bench trade`: what is changed here by hand is lost. Texts are in xtask/src/trade. -->

# Speed for accuracy

Users trade speed for accuracy. Here are the dials of the system by which they do, each with the time that a setting takes and the error that it
reaches. `cargo xtask bench trade` measures all of them, by the code that a run uses, and writes this page, its picture and [trade.csv](trade.csv).
Errors are held against a truth that the measured code did not make; what it is stands under each table. Times are medians of processor time of
one thread, but where the unit says otherwise, of settings that took turns. Compare ratios, which are over the **bold** setting in the same run: the default,
where there is one. Dials are turned one at a time, the others at their defaults.

";

const AFTER: &str = "
![Error over time of each dial, both over those of the bold setting](trade.png)

In the picture both are over those of the bold setting, so that all dials meet in (1, 1): down is more accurate, left is faster, and a line that falls to
the right is a dial that trades. A line goes from its large dot through the rows of the dial's table; triangles are a choice of several ways.

What is not here: rates and lags with a person at the other end ([a hand in silico](hand.md)), and what all errors make together at the target of an
operation ([accuracy of whole operations](accuracy.md)).
";

/// The page. `made` is the line of [`made`], without its end.
pub(super) fn page(measured: &[Measured], made: &str) -> String {
    let mut page = format!("{HEAD}{made}\n{AFTER}");
    for (number, group) in GROUPS.iter().enumerate() {
        let _ = write!(page, "\n## {group}\n");
        for one in measured.iter().filter(|m| m.dial.group == number) {
            page.push_str(&section(one));
        }
    }
    page
}

fn section(one: &Measured) -> String {
    let dial = one.dial;
    let mut text = format!(
        "\n### {}\n\n{}\n{}\n\n| setting | time, {} | ratio | error, {} |\n|---|---|---|---|\n",
        dial.title,
        turned_by(dial.key),
        dial.what,
        one.time_unit,
        one.error_unit
    );
    for setting in &one.settings {
        let bold = if setting.is_chosen { "**" } else { "" };
        let Setting {
            name,
            time,
            ratio,
            error,
            ..
        } = setting;
        let [time, ratio, error] = [time, ratio, error].map(|x| three(*x));
        let _ = writeln!(
            text,
            "| {bold}{name}{bold} | {bold}{time}{bold} | {bold}{ratio}{bold} | {bold}{error}{bold} |"
        );
    }
    let _ = write!(text, "\nError: {}.\n", one.against);
    text
}

/// Read again by a test (tests/cli/help/trade.rs) that looks whether the dial is still there.
fn turned_by(key: Key) -> String {
    match key {
        Key::Scene(key) => format!("Turned by the scene's `{key}`."),
        Key::Option(option) => format!("Turned by `{option}`."),
        Key::File(file, word) => format!("Turned by `{word}` in a file like `{file}`."),
        Key::Code(file, word) => format!("No key: `{word}` in `{file}`."),
    }
}

/// Three digits, as powers of ten only where there is no other way.
pub(super) fn three(x: f64) -> String {
    let digits = 2 - x.abs().log10().floor() as i32;
    match digits {
        0..=6 => format!("{x:.*}", digits as usize),
        -3..0 => format!("{x:.0}"),
        _ => format!("{x:.2e}"),
    }
}

/// How busy the machine is.
pub(super) fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace().next().unwrap_or("unknown").to_owned()
}

/// The line that says where, and how busy the machine was before and after.
pub(super) fn made(before: &str, is_quick: bool) -> String {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu.lines().find_map(|l| l.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("an unknown processor", |(_, name)| name);
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let quick = if is_quick {
        ", with `--quick`: the numbers mean little"
    } else {
        ""
    };
    format!(
        "{MADE}on {cores} cores of {model}, at a load of {before} before and {} after (others worked beside){quick}.",
        load()
    )
}

#[cfg(test)]
mod tests {
    use super::super::dials::DIALS;
    use super::*;

    const PAGE: &str = include_str!("../../../docs/trade.md");
    const ROWS: &str = include_str!("../../../docs/trade.csv");

    #[test]
    fn numbers_have_three_digits() {
        let texts = [1234.4, 123.4, 1.0, 0.01234, 1.234e-7, 9.999].map(three);
        assert_eq!(texts, ["1234", "123", "1.00", "0.0123", "1.23e-7", "10.00"]);
    }

    #[test]
    fn the_page_is_what_its_rows_and_dials_make() {
        let measured = Measured::parse(ROWS, &DIALS).unwrap();
        let made = PAGE.lines().find(|line| line.starts_with(MADE)).unwrap();
        assert!(!made.contains("--quick"), "{made}");
        let page = page(&measured, made);
        let differs = PAGE.lines().zip(page.lines()).find(|(is, ought)| is != ought);
        assert!(
            page == PAGE,
            "docs/trade.md is not what `cargo xtask bench trade --again` makes: {differs:?}"
        );
    }
}
