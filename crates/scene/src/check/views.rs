//! The views of a scene, checked.

use crate::raw::{Plane, RawView, RawWindow};
use crate::values::{Checked, invalid, number, repeated};
use crate::view::WINDOWS;
use crate::{Sampling, THICKNESS_MM, View, WindowLevel};

const MAX_VIEWS: usize = 16;

pub(super) fn views(raw: Option<&[RawView]>) -> Checked<Vec<View>> {
    let Some(raw) = raw else {
        return Ok(View::thesis_seven());
    };
    if raw.is_empty() || raw.len() > MAX_VIEWS {
        return Err(invalid("views", raw.len(), format!("1 to {MAX_VIEWS} views")));
    }
    let views: Vec<View> = raw.iter().enumerate().map(view).collect::<Checked<_>>()?;
    if let Some((i, name)) = repeated(views.iter().map(|v| v.name.as_str())) {
        return Err(invalid(
            format!("views.{i}.name"),
            format!("{name:?} a second time"),
            "a name of its own",
        ));
    }
    Ok(views)
}

fn view((i, raw): (usize, &RawView)) -> Checked<View> {
    let key = |name: &str| format!("views.{i}.{name}");
    let in_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if raw.name.is_empty() || raw.name.len() > 32 || !raw.name.chars().all(in_name) {
        let allowed = "1 to 32 of the characters a-z, 0-9 and '-', as it names a file";
        return Err(invalid(key("name"), format!("{:?}", raw.name), allowed));
    }
    if raw.name == "sheet" {
        return Err(invalid(
            key("name"),
            "\"sheet\"",
            "another name: sheet.png is the contact sheet",
        ));
    }
    if raw.size.iter().any(|n| !(64..=4096).contains(n)) {
        return Err(invalid(
            key("size"),
            format!("{:?}", raw.size),
            "64 to 4096 pixels a side",
        ));
    }
    Ok(View {
        name: raw.name.clone(),
        plane: raw.plane,
        extent: raw.extent,
        size: raw.size,
        field_mm: number(&key("field_mm"), raw.field_mm, 1.0..=2000.0, "mm")?,
        sampling: sampling(raw, key)?,
        ahead_mm: ahead(&key("ahead_mm"), raw)?,
        window: window(&key("window"), &raw.window)?,
        up: raw.up,
        text: number(&key("text"), raw.text, 0.5..=4.0, "times the usual size")?,
        overlay: raw.overlay,
    })
}

/// How a view samples; `key` names one of its keys.
fn sampling(raw: &RawView, key: impl Fn(&str) -> String) -> Checked<Sampling> {
    if let Some(slab) = &raw.slab {
        number(&key("slab.thickness_mm"), slab.thickness_mm, THICKNESS_MM, "mm")?;
    }
    Ok(Sampling {
        filter: raw.filter,
        slab: raw.slab,
        minify: raw.minify,
    })
}

/// Only a perpendicular view looks ahead: the others show the planes through the tip.
fn ahead(key: &str, raw: &RawView) -> Checked<f64> {
    if raw.plane != Plane::Perpendicular && raw.ahead_mm != 0.0 {
        let allowed = "0, or plane = \"perpendicular\": the other planes go through the tip";
        return Err(invalid(key, raw.ahead_mm, allowed));
    }
    number(key, raw.ahead_mm, -200.0..=200.0, "mm")
}

fn window(key: &str, raw: &RawWindow) -> Checked<WindowLevel> {
    match raw {
        RawWindow::Named(name) => WindowLevel::named(name).ok_or_else(|| {
            let names: Vec<_> = WINDOWS.iter().map(|(name, _)| *name).collect();
            let allowed = format!("{}, or {{ centre_hu = .., width_hu = .. }}", names.join(", "));
            invalid(key, format!("{name:?}"), allowed)
        }),
        RawWindow::Levels(levels) => Ok(WindowLevel {
            centre_hu: number(
                &format!("{key}.centre_hu"),
                levels.centre_hu,
                -32_768.0..=32_767.0,
                "HU",
            )?,
            width_hu: number(&format!("{key}.width_hu"), levels.width_hu, 1.0..=65_536.0, "HU")?,
        }),
    }
}
