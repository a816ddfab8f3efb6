//! Organs that a model moved.

use bus::message::TissueShown;

use super::escape::own;
use super::table::{more, pairs, paragraph, table};
use super::units::{moment, number};
use crate::report::facts::Facts;
use crate::report::run_report::Tissue;

/// The section; empty where nothing moved organs.
pub(super) fn section(facts: &Facts) -> String {
    let organs = &facts.organs;
    if !facts.basis.moves_organs() && organs.states.is_empty() {
        return String::new();
    }
    let mut page = String::from("<section>\n<h2>Organs that the tube moves, by a model</h2>\n");
    page += &match facts.basis.images_of_organs() {
        Some(tissue) => images(tissue),
        None => paragraph("What images showed is <strong>not known</strong>: the run's own report does not say."),
    };
    let states: Vec<String> = organs.states.iter().map(|(word, n)| format!("{n} {word}")).collect();
    let states = match &states[..] {
        [] => "none are recorded".to_owned(),
        states => states.join(", "),
    };
    let force = organs
        .largest_force
        .map_or("no settled state is recorded".to_owned(), |force| {
            format!("{} N at {}", number(force.newton), moment(force.t_ns))
        });
    page += &pairs(&[
        ("States of the model", states),
        ("Largest force on the tube, of settled ones", force),
    ]);
    page += &paragraph(
        "A settled state is in balance by the model's own numbers; how well these are the patient's is not in it. Errors \
         that were stated with states are in the recording (<code>/tissue</code>).",
    );
    page + "</section>\n"
}

fn images(tissue: &Tissue) -> String {
    let meaning = |shown: TissueShown| match shown {
        TissueShown::None => "nothing was said of organs: that must never be",
        TissueShown::Settled => "where a state in balance has them",
        TissueShown::Approximate => "where a state has them that had not settled; the image said so",
        TissueShown::Late => "at rest, as no state came in time",
        TissueShown::CatchingUp => "at rest, while the model was on its way to the pose",
        TissueShown::Refused => "at rest, as the model did not bear the pose",
        TissueShown::Rigid => "at rest, as a person or the kind of view wanted it",
    };
    let known = TissueShown::ALL.iter().skip(1);
    let row = |shown: &TissueShown| {
        vec![
            shown.word().to_owned(),
            meaning(*shown).to_owned(),
            tissue.count(*shown).to_string(),
        ]
    };
    let mut page = table(
        &["Image", "Organs", "First images of a pose, whole run"],
        &known.map(row).collect::<Vec<_>>(),
    )
    .unwrap_or_default();
    page += &pairs(&[
        ("Images that said nothing of organs", tissue.unmarked.to_string()),
        (
            "Images on which tissue lay over itself",
            tissue.covered_twice.to_string(),
        ),
    ]);
    let because: Vec<_> = tissue
        .refused_because
        .iter()
        .take(100)
        .map(|(why, n)| vec![own(why), n.to_string()])
        .collect();
    page += &table(
        &["Why the model did not bear a pose", "First images, whole run"],
        &because,
    )
    .unwrap_or_default();
    page + &more(tissue.refused_because.len().saturating_sub(100) as u64, "reasons")
}
