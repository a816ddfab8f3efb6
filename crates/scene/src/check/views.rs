//! The views of a scene, checked.

use crate::raw::{Extent, Plane, RawAngles, RawFrom, RawView, RawWindow};
use crate::values::{Checked, invalid, number, repeated};
use crate::view::{SIDES, WINDOWS};
use crate::{Sampling, Surface, THICKNESS_MM, View, WindowLevel};

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
        surface: surface(raw, key)?,
    })
}

/// The table of a surface view; `key` names one of the view's keys.
fn surface(raw: &RawView, key: impl Fn(&str) -> String) -> Checked<Surface> {
    if raw.plane != Plane::Surface {
        let allowed = "no such table unless plane = \"surface\"";
        return match raw.surface {
            None => Ok(Surface::default()),
            Some(_) => Err(invalid(key("surface"), "a table", allowed)),
        };
    }
    if raw.extent == Extent::Local {
        let allowed = "\"global\" for plane = \"surface\", which does not move with the tip";
        return Err(invalid(key("extent"), "\"local\"", allowed));
    }
    if raw.slab.is_some() {
        let allowed = "no thickness for plane = \"surface\", which is no slice";
        return Err(invalid(key("slab"), "a table", allowed));
    }
    let surface = raw.surface.clone().unwrap_or_default();
    let bone_hu = number(&key("surface.bone_hu"), surface.bone_hu, -1000.0..=4000.0, "HU")?;
    let field = |mm| number(&key("surface.field_mm"), mm, 10.0..=2000.0, "mm");
    Ok(Surface {
        field_mm: surface.field_mm.map(field).transpose()?,
        ..from(&surface.from, bone_hu, |name| key(&format!("surface.from{name}")))?
    })
}

fn from(from: &RawFrom, bone_hu: f64, key: impl Fn(&str) -> String) -> Checked<Surface> {
    match from {
        RawFrom::Named(name) => Surface::from(name, bone_hu).ok_or_else(|| {
            let names = SIDES.map(|(name, _)| name).join(", ");
            let allowed = format!("{names}, or {{ azimuth_deg = .., elevation_deg = .. }}");
            invalid(key(""), format!("{name:?}"), allowed)
        }),
        RawFrom::Angles(RawAngles {
            azimuth_deg,
            elevation_deg,
        }) => Ok(Surface {
            azimuth_rad: number(&key(".azimuth_deg"), *azimuth_deg, -360.0..=360.0, "degrees")?.to_radians(),
            elevation_rad: number(&key(".elevation_deg"), *elevation_deg, -90.0..=90.0, "degrees")?.to_radians(),
            field_mm: None,
            bone_hu,
        }),
    }
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

#[cfg(test)]
mod tests {
    use crate::Scene;
    use std::path::Path;

    fn of(keys: &str) -> Result<Scene, String> {
        let text = format!("[[views]]\nname = \"surface\"\n{keys}");
        Scene::parse(&text, Path::new("s.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn a_surface_has_a_direction_by_name_or_angles() {
        let surface = |more: &str| {
            let scene = of(&format!("plane = \"surface\"\nextent = \"global\"\n{more}")).unwrap();
            assert_eq!(scene.renderers().len(), 1);
            scene.views[0].surface
        };
        let front = surface("");
        assert_eq!(
            (front.azimuth_rad, front.elevation_rad, front.field_mm, front.bone_hu),
            (0.0, 0.0, None, 300.0)
        );
        let left = surface("surface = { from = \"left\", field_mm = 400, bone_hu = 250 }");
        assert_eq!(
            (left.azimuth_rad, left.field_mm, left.bone_hu),
            (std::f64::consts::FRAC_PI_2, Some(400.0), 250.0)
        );
        let oblique = surface("surface = { from = { azimuth_deg = -50, elevation_deg = 20 } }");
        assert!((oblique.azimuth_rad + 0.872_665).abs() < 1e-6 && (oblique.elevation_rad - 0.349_065).abs() < 1e-6);
    }

    #[test]
    fn what_means_nothing_for_a_surface_or_without_one_is_refused_by_key() {
        let surface = "plane = \"surface\"\nextent = \"global\"";
        for (keys, said) in [
            (
                "plane = \"surface\"\nextent = \"local\"",
                "key views.0.extent: found \"local\"",
            ),
            (
                "plane = \"axial\"\nextent = \"global\"\nsurface = {}",
                "key views.0.surface: found a table",
            ),
            (
                &format!("{surface}\nslab = {{ mode = \"mean\", thickness_mm = 2 }}"),
                "key views.0.slab",
            ),
            (&format!("{surface}\nahead_mm = 5"), "key views.0.ahead_mm"),
            (
                &format!("{surface}\nsurface = {{ from = \"below\" }}"),
                "anterior, left, posterior, right, head, feet",
            ),
            (
                &format!("{surface}\nsurface = {{ bone_hu = nan }}"),
                "key views.0.surface.bone_hu: found NaN",
            ),
            (
                &format!("{surface}\nsurface = {{ field_mm = 1e9 }}"),
                "key views.0.surface.field_mm",
            ),
            (
                &format!("{surface}\nsurface = {{ from = {{ azimuth_deg = inf }} }}"),
                "key views.0.surface.from.azimuth_deg",
            ),
            (
                &format!("{surface}\nsurface = {{ from = {{ azimuth_deg = 0, elevation_deg = 91 }} }}"),
                "key views.0.surface.from.elevation_deg: found 91",
            ),
        ] {
            let found = of(keys).unwrap_err();
            assert!(found.contains(said), "{keys}: {found}");
        }
    }
}
