//! What a person chose and marked.

use super::escape::{own, text};
use super::table::{more, paragraph, table};
use super::units::{moment, number, place};
use crate::report::facts::Facts;
use crate::report::marks::{Mark, Near};
use crate::report::story::Choice;
use picture::base64;

/// The chosen targets over time.
pub(super) fn targets(facts: &Facts) -> String {
    let choices = &facts.story.choices;
    let rows: Vec<_> = choices.listed.iter().map(row).collect();
    let heads = [
        "From, min:s",
        "Target",
        "Plan id",
        "Centre, LPS mm",
        "Radius, mm",
        "Stop before it, mm",
        "Pose held",
    ];
    let table = table(&heads, &rows).unwrap_or_else(|| paragraph("The recording does not tell of any choice."));
    format!(
        "<section>\n<h2>Chosen targets</h2>\n{table}{}</section>\n",
        more(choices.more(), "choices")
    )
}

fn row(choice: &Choice) -> Vec<String> {
    let held = choice.held_seq.map_or("-".to_owned(), |seq| format!("number {seq}"));
    let none = || "-".to_owned();
    let Some(target) = &choice.target else {
        return vec![
            moment(choice.t_ns),
            "none".to_owned(),
            none(),
            none(),
            none(),
            none(),
            held,
        ];
    };
    vec![
        moment(choice.t_ns),
        own(&target.name),
        format!("<code>{}</code>", text(&target.plan_id)),
        place(target.centre_mm),
        number(target.radius_mm),
        number(target.stop_mm),
        held,
    ]
}

/// The marks with their pictures.
pub(super) fn marks(facts: &Facts) -> String {
    let marks = &facts.marks;
    let mut page = String::from("<section>\n<h2>Marks</h2>\n");
    if marks.listed.is_empty() {
        return page + &paragraph("Nothing was marked.") + "</section>\n";
    }
    let row = |(mark, number): (&Mark, u64)| vec![number.to_string(), moment(mark.t_ns), own(&mark.words)];
    let rows: Vec<_> = marks.listed.iter().zip(1..).map(row).collect();
    page += &table(&["Number", "Time, min:s", "Words"], &rows).unwrap_or_default();
    page += &more(marks.count - marks.listed.len() as u64, "marks");
    page += "<h3>Pictures at the marks</h3>\n";
    if marks.pictures == 0 {
        page += &paragraph(
            "The recording holds no pictures, so no mark has one (<code>thumbnails_per_s</code> of its scene).",
        );
        return page + "</section>\n";
    }
    if marks.pictures_refused > 0 {
        page += &paragraph(&format!(
            "{} pictures of the recording are no PNG that can be shown.",
            marks.pictures_refused
        ));
    }
    page += &paragraph("The nearest picture of each view, with the time between the mark and when it was shown.");
    for ((mark, why), number) in marks.listed.iter().zip(&marks.why_none).zip(1..) {
        page += &pictured(mark, why, number);
    }
    page + "</section>\n"
}

fn pictured(mark: &Mark, why: &str, number: u64) -> String {
    let head = format!(
        "<p><strong>{number}</strong>, {}: {}</p>\n",
        moment(mark.t_ns),
        own(&mark.words)
    );
    let body = match mark.pictures.is_empty() {
        true => paragraph(&text(why)),
        false => format!(
            "<div class=\"pictures\">\n{}</div>\n",
            mark.pictures.iter().map(figure).collect::<String>()
        ),
    };
    format!("<div class=\"mark\">\n{head}{body}</div>\n")
}

fn figure(near: &Near) -> String {
    let seconds = near.later_ns.unsigned_abs() as f64 / 1e9;
    let when = match near.later_ns {
        0 => "at the mark".to_owned(),
        1.. => format!("{seconds:.2} s after the mark"),
        _ => format!("{seconds:.2} s before the mark"),
    };
    format!(
        "<figure><img alt=\"{}, {when}\" src=\"data:image/png;base64,{}\"/><figcaption>{}<br/>{when}</figcaption></figure>\n",
        text(&near.view),
        base64::encode(&near.png),
        own(&near.view)
    )
}
