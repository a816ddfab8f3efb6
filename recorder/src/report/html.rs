//! The page: HTML that is well-formed XML too, with its style and its drawings in it.

mod axis;
mod basis;
mod checks;
mod curve;
mod escape;
mod head;
mod localizer;
mod marked;
mod measured;
mod organs;
mod strip;
mod table;
mod troubles;
mod units;

use axis::TimeAxis;
use escape::text;

use super::facts::Facts;

const STYLE: &str = include_str!("html/style.css");
/// Nothing is loaded and nothing runs, whatever a text of the recording might say.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

/// The whole page.
pub(super) fn page(facts: &Facts) -> String {
    let (from_ns, to_ns) = facts.recording.span_ns.unwrap_or_default();
    let time = TimeAxis { from_ns, to_ns };
    let title = format!("Session report: {}", text(&facts.recording.name));
    let sections = [
        head::section(facts),
        basis::section(facts),
        checks::section(facts),
        marked::targets(facts),
        marked::marks(facts),
        measured::states(facts, &time),
        measured::tip(facts, &time),
        measured::latency(facts, &time),
        localizer::section(facts),
        organs::section(facts),
        troubles::section(facts),
        troubles::damage(facts),
    ];
    let sections: String = sections.concat();
    format!(
        "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width\"/>\n<title>{title}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{sections}\
         <p class=\"foot\">Made by {} from {}, BLAKE3 {}. Research software, not a medical device.</p>\n</body>\n</html>\n",
        text(facts.made_by),
        text(&facts.recording.name),
        facts.recording.blake3,
    )
}
