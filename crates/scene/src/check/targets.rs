//! Targets, and the one that is chosen at the start.

use crate::Target;
use crate::raw::{RawScene, RawTarget};
use crate::values::{Checked, invalid, number, point, repeated};

const MAX_TARGETS: usize = 64;

/// Checks `[[targets]]`.
pub(super) fn targets(raw: &[RawTarget]) -> Checked<Vec<Target>> {
    if raw.len() > MAX_TARGETS {
        return Err(invalid("targets", raw.len(), format!("at most {MAX_TARGETS} targets")));
    }
    let targets: Vec<Target> = raw.iter().enumerate().map(target).collect::<Checked<_>>()?;
    if let Some((i, name)) = repeated(targets.iter().map(|t| t.name.as_str())) {
        return Err(invalid(
            format!("targets.{i}.name"),
            format!("{name:?} a second time"),
            "a name of its own",
        ));
    }
    Ok(targets)
}

fn target((i, raw): (usize, &RawTarget)) -> Checked<Target> {
    let key = |name: &str| format!("targets.{i}.{name}");
    // Names go over the bus in fields that end with their first 0: one behind it would not be told from one before it.
    if raw.name.is_empty() || raw.name.len() > 40 || raw.name.contains('\0') {
        return Err(invalid(
            key("name"),
            format!("{:?}", raw.name),
            "1 to 40 bytes, none of them 0",
        ));
    }
    Ok(Target {
        name: raw.name.clone(),
        centre: point(&key("ct_mm"), raw.ct_mm)?,
        diameter_mm: number(&key("diameter_mm"), raw.diameter_mm, 0.1..=200.0, "mm")?,
        entry: raw.entry_ct_mm.map(|mm| point(&key("entry_ct_mm"), mm)).transpose()?,
        stop_mm: number(&key("stop_mm"), raw.stop_mm, 0.0..=500.0, "mm")?,
    })
}

/// A target's name under this key, or what is allowed there.
pub(super) fn named(key: &str, name: &str, targets: &[Target]) -> Checked<()> {
    if targets.iter().any(|t| t.name == name) {
        return Ok(());
    }
    let names: Vec<_> = targets.iter().map(|t| t.name.as_str()).collect();
    let allowed = match names.is_empty() {
        true => "no target, as the scene has none".to_owned(),
        false => format!("one of the scene's targets: {}", names.join(", ")),
    };
    Err(invalid(key, format!("{name:?}"), allowed))
}

/// The target that is chosen at the start. A scene of the generated patient that lists no targets may name one of that
/// patient's, who is not known here: whoever adds them checks again.
pub(super) fn chosen(raw: &RawScene, targets: &[Target]) -> Checked<Option<String>> {
    let are_added_later = raw.targets.is_none() && raw.volume.source == "phantom";
    if let Some(name) = raw.guide.target.as_deref().filter(|_| !are_added_later) {
        named("guide.target", name, targets)?;
    }
    Ok(raw.guide.target.clone())
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use geometry::Point;
    use std::path::Path;

    const TWO: &str = "[[targets]]\nname = \"a\"\nct_mm = [1, 2, 3]\nentry_ct_mm = [4, 5, 6]\nstop_mm = 7\n\
                       [[targets]]\nname = \"b\"\nct_mm = [1, 2, 3]";

    fn parsed(text: &str) -> Result<Scene, String> {
        Scene::parse(text, Path::new("s.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn a_target_has_an_entry_and_a_stop_distance() {
        let scene = parsed(&format!("[guide]\ntarget = \"b\"\n{TWO}")).unwrap();
        assert_eq!(scene.guide.as_deref(), Some("b"));
        let [a, b] = &scene.targets[..] else { panic!() };
        assert_eq!((a.entry, a.stop_mm), (Some(Point::new(4.0, 5.0, 6.0)), 7.0));
        assert_eq!((b.entry, b.stop_mm), (None, 0.0));
    }

    #[test]
    fn what_is_no_plan_is_refused_with_its_line_and_what_is_allowed() {
        let of = |line: &str| format!("[[targets]]\nname = \"a\"\nct_mm = [1, 2, 3]\n{line}");
        for (text, said) in [
            (
                of("stop_mm = -1"),
                "line 4, column 11, key targets.0.stop_mm: found -1; allowed: 0 to 500 mm",
            ),
            (of("stop_mm = nan"), "key targets.0.stop_mm: found NaN"),
            (of("stop_mm = inf"), "key targets.0.stop_mm: found inf"),
            (of("entry_ct_mm = [0, nan, 0]"), "key targets.0.entry_ct_mm"),
            (
                format!("[guide]\ntarget = \"c\"\n{TWO}"),
                "line 2, column 10, key guide.target: found \"c\"; allowed: one of the scene's targets: a, b",
            ),
            (
                "[guide]\ntarget = \"c\"\n[volume]\nsource = \"a.nii\"".to_owned(),
                "key guide.target: found \"c\"; allowed: no target, as the scene has none",
            ),
            (
                "targets = []\n[guide]\ntarget = \"c\"".to_owned(),
                "key guide.target: found \"c\"; allowed: no target",
            ),
            ("[guide]\ntraget = \"a\"".to_owned(), "unknown field `traget`"),
            (
                "[[targets]]\nname = \"a\\u0000b\"\nct_mm = [1, 2, 3]".to_owned(),
                "allowed: 1 to 40 bytes, none of them 0",
            ),
        ] {
            let found = parsed(&text).unwrap_err();
            assert!(found.contains(said), "{text}\n  gave {found}");
        }
        // Of the generated patient, whose targets are added later.
        assert_eq!(parsed("[guide]\ntarget = \"c\"").unwrap().guide.as_deref(), Some("c"));
    }
}
