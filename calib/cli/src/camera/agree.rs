//! Which views agree on one camera, in words, where all together do not.

use optics::camera::{Agreeing, CameraRefused, Gates, Options, Short, View, agreeing};

use super::read::Seen;

/// How many views are named.
const NAMED: usize = 12;

/// What is said beside what falls short, after its sentence.
pub(super) fn beside(short: &Short, views: &[View], seen: &Seen, options: &Options) -> String {
    let (Short::Noise { limit, .. } | Short::Views { limit, .. }) = short else {
        return String::new();
    };
    let said = said(views, seen, options, *limit);
    ". ".to_owned()
        + &said.unwrap_or_else(|| "No three views agree better: look at --lens and --plate first".to_owned())
}

/// The advice on a refusal, with what is said of the views where those of another camera may be the cause.
pub(super) fn after(
    advice: &str,
    refused: &CameraRefused,
    (views, seen, options): (&[View], &Seen, &Options),
) -> String {
    use CameraRefused::{Folded, NoConvergence, NotFlat, Outliers};
    let may_be = matches!(
        refused,
        Outliers { .. } | NotFlat { .. } | Folded { .. } | NoConvergence { .. }
    );
    let limit = Gates::default().max_noise_ratio.unwrap_or(f64::INFINITY);
    match may_be.then(|| said(views, seen, options, limit)).flatten() {
        Some(said) => format!("{advice}{} {said}", if advice.ends_with('?') { "" } else { "." }),
        None => advice.to_owned(),
    }
}

fn said(views: &[View], seen: &Seen, options: &Options, limit: f64) -> Option<String> {
    let Agreeing { group, ratio, others } = agreeing(views, seen.size, options, limit)?;
    let named = |inside: bool| {
        let some = seen.images.iter().zip(&group).filter(|(_, g)| **g == inside);
        let names: Vec<&str> = some.map(|(image, _)| image.name.as_str()).collect();
        match names.len().saturating_sub(NAMED) {
            0 => names.join(", "),
            more => format!("{} and {more} more", names[..NAMED].join(", ")),
        }
    };
    let own = match others {
        Some(ratio) => {
            format!(", which agree on a camera of their own ({ratio:.1}): two cameras, or two settings of one")
        }
        None => String::new(),
    };
    Some(format!(
        "{} agree on one camera ({ratio:.1} times their deviations), but not with {}{own}",
        named(true),
        named(false)
    ))
}
