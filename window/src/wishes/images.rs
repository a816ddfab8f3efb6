//! From a key to the window or the field that it asks for.

use bus::message::{Change, Images, ImagesWish};
use scene::{Extent, Scene, WindowLevel};

use crate::screen::ImagesKey;

/// The windows of the number keys.
const NAMES: [&str; 5] = ["abdomen", "soft-tissue", "bone", "lung", "vessels"];
/// Fields, mm, and widths, HU, that keys lead to.
const FIELDS_MM: [f64; 16] = [
    10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0, 120.0, 150.0, 200.0, 250.0, 300.0, 400.0, 500.0,
];
const WIDTHS_HU: [f64; 16] = [
    50.0, 100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0, 500.0, 600.0, 800.0, 1000.0, 1500.0, 2000.0, 3000.0, 4000.0,
];
/// The centre moves by this part of the width, and to a multiple of this, HU.
const PART: f64 = 0.1;
const ROUND_HU: f64 = 5.0;

/// What `key` asks for where images look like `now`.
pub(super) fn wish(key: ImagesKey, now: Images, scene: &Scene) -> Result<ImagesWish, String> {
    let window = window(now, scene)?;
    let set = |window| ImagesWish {
        window: Change::Set(window),
        ..ImagesWish::default()
    };
    let wide = |width_hu| set(WindowLevel { width_hu, ..window });
    let moved = |sign: f64| {
        let by = (PART * window.width_hu / ROUND_HU).ceil() * ROUND_HU;
        set(WindowLevel {
            centre_hu: window.centre_hu + sign * by,
            ..window
        })
    };
    let wish = match key {
        ImagesKey::Window(place) => NAMES.get(place).and_then(|name| WindowLevel::named(name)).map(set),
        ImagesKey::Narrower => below(&WIDTHS_HU, window.width_hu).map(wide),
        ImagesKey::Wider => above(&WIDTHS_HU, window.width_hu).map(wide),
        ImagesKey::Lighter => Some(moved(-1.0)),
        ImagesKey::Darker => Some(moved(1.0)),
        ImagesKey::Closer => below(&FIELDS_MM, field(now, scene)?).map(shown),
        ImagesKey::Further => above(&FIELDS_MM, field(now, scene)?).map(shown),
        ImagesKey::Scene => Some(ImagesWish {
            field_mm: Change::Scene,
            window: Change::Scene,
            at_rest: Change::Scene,
        }),
        ImagesKey::Organs => Some(ImagesWish {
            at_rest: Change::Set(!now.at_rest),
            ..ImagesWish::default()
        }),
    };
    wish.ok_or_else(|| "no key leads further; `pilot images` sets any window and field".to_owned())
}

/// The window that holds.
pub(super) fn window(now: Images, scene: &Scene) -> Result<WindowLevel, String> {
    let first = scene.views.first().ok_or("the scene has no images")?;
    Ok(now.window.unwrap_or(first.window))
}

/// The field of local images; an error where there are none.
fn field(now: Images, scene: &Scene) -> Result<f64, String> {
    let local = scene.views.iter().find(|view| view.extent == Extent::Local);
    let local = local.ok_or("no image of the scene is local")?;
    Ok(now.field_mm.unwrap_or(local.field_mm))
}

fn shown(mm: f64) -> ImagesWish {
    ImagesWish {
        field_mm: Change::Set(mm),
        ..ImagesWish::default()
    }
}

fn below(steps: &[f64], value: f64) -> Option<f64> {
    steps.iter().rev().copied().find(|step| *step < value)
}

fn above(steps: &[f64], value: f64) -> Option<f64> {
    steps.iter().copied().find(|step| *step > value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn keys_lead_from_what_holds_and_end_where_a_scene_would() {
        let scene = Scene::parse("", Path::new("")).unwrap();
        let mut images = Images::default();
        let mut press = |key| -> Result<Images, String> {
            images = images.with(wish(key, images, &scene)?).checked().unwrap();
            Ok(images)
        };
        assert_eq!(press(ImagesKey::Closer).unwrap().field_mm, Some(80.0));
        assert_eq!(press(ImagesKey::Further).unwrap().field_mm, Some(100.0));
        let bone = press(ImagesKey::Window(2)).unwrap();
        assert_eq!(bone.window, WindowLevel::named("bone"));
        let window = press(ImagesKey::Narrower).unwrap().window.unwrap();
        assert_eq!((window.width_hu, window.centre_hu), (1500.0, 400.0));
        assert_eq!(press(ImagesKey::Lighter).unwrap().window.unwrap().centre_hu, 250.0);
        assert_eq!(press(ImagesKey::Darker).unwrap().window.unwrap().centre_hu, 400.0);
        for key in [
            ImagesKey::Closer,
            ImagesKey::Further,
            ImagesKey::Narrower,
            ImagesKey::Wider,
        ] {
            let last = (0..40).find_map(|_| press(key).err()).unwrap();
            assert!(last.contains("pilot images"), "{last}");
        }
        assert!(press(ImagesKey::Organs).unwrap().at_rest && !press(ImagesKey::Organs).unwrap().at_rest);
        assert!(press(ImagesKey::Organs).unwrap().at_rest);
        assert_eq!(press(ImagesKey::Scene).unwrap(), Images::default());
        for k in 0..5 {
            assert!(press(ImagesKey::Window(k)).is_ok());
        }
    }
}
