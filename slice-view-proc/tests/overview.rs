//! The overview: the right side of the right patient, what lies before what, and what it says.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod common;

use std::path::Path;
use std::sync::Arc;

use bus::message::{Chosen, Lost, Marks};
use bus::volume::OwnedVolume;
use common::{volume, volume_at};
use geometry::{Ct, Direction, Point, Rigid, SlicePlane, Tool};
use phantom::Phantom;
use scene::Scene;
use slice_view_proc::reslice::Cpu;
use slice_view_proc::{Anatomy, Notice, Origin, Rendered, Renderer};

const GROUND: [u8; 3] = [12, 14, 22];
const TUBE: [u8; 3] = [0x78, 0xb7, 0xdc];

/// A scene with one surface view; `table` is its `surface`, `more` stands behind it.
fn scene(size: [u32; 2], table: &str, more: &str) -> Scene {
    let text = format!(
        "[[views]]\nname = \"s\"\nplane = \"surface\"\nextent = \"global\"\nsize = [{}, {}]\nsurface = {table}\n{more}",
        size[0], size[1]
    );
    Scene::parse(&text, Path::new("")).unwrap()
}

fn what(volume: &OwnedVolume) -> Rendered<'_> {
    Rendered {
        volume: volume.view(),
        volume_name: "01234567",
        marks: Marks::NONE,
        pose: None,
        accuracy: None,
        notice: Notice::Live,
        origin: Origin::Tracker,
        remarks: &[],
        chosen: None,
        seq: 7,
        registration_id: 1,
        tissue: slice_view_proc::tissue::Tissues::default(),
    }
}

/// A renderer of the scene's first view, with the anatomy of `volume`.
fn renderer(scene: &Scene, volume: &OwnedVolume) -> Renderer {
    let view = &scene.views[0];
    let mut renderer = Renderer::new(view.clone());
    renderer.show_anatomy(Arc::new(Anatomy::of(
        &volume.view(),
        view.surface.bone_hu,
        None,
        &mut || {},
    )));
    renderer
}

fn image(renderer: &mut Renderer, what: &Rendered<'_>, scene: &Scene) -> Vec<[u8; 3]> {
    renderer.render(what, scene, &mut Cpu::default()).unwrap();
    assert_eq!(renderer.plane(), None);
    let pixels = renderer.canvas().rgba().chunks(4);
    pixels.map(|pixel| pixel[..3].try_into().unwrap()).collect()
}

/// A tube whose tip is at `tip` and which goes along `along`.
fn tube(tip: [f64; 3], along: Direction<Ct>) -> Rigid<Ct, Tool> {
    let up = if along.components()[2].abs() < 0.5 {
        Direction::Z
    } else {
        Direction::Y
    };
    Rigid::from_axes(Point::new(tip[0], tip[1], tip[2]), along, up).unwrap()
}

/// Whether the ray of a pixel meets bone, of the generated patient's formula: no voxels, no triangles.
fn meets_bone(patient: &Phantom, seen: &SlicePlane, [x, y]: [f64; 2], bone_hu: f64) -> bool {
    let start = seen.point(x, y) + seen.into_screen() * -250.0;
    (0..500).any(|i| {
        let p = start + seen.into_screen() * f64::from(i);
        // Bone at the ends of the scan is seen on its cut.
        (-133.0..213.0).contains(&p.mm()[2]) && patient.hu(p) >= bone_hu
    })
}

/// The patient is not symmetric: the vessels with contrast are on the left, and no two bones of a side are those of the other. Small images
/// have no words, and no letter hides a pixel.
#[test]
fn no_side_is_mistaken() {
    let patient = Phantom::new(1);
    let grid = patient.grid([2.0; 3]).unwrap();
    let [nx, ny, _] = grid.dims();
    // As it stands, and with its columns from right to left, which is a left-handed grid: the patient is the same.
    let rows = grid.ct_from_voxel().rows();
    let flipped = {
        let last = f64::from(nx) - 1.0;
        rows.map(|[a, b, c, d]| [-a, b, c, d + a * last])
    };
    let straight = {
        let mut slice = vec![0_i16; (nx * ny) as usize];
        let mut filled = None;
        let slices = std::cell::RefCell::new(move |[x, y, z]: [i64; 3]| {
            if filled.replace(z) != Some(z) {
                patient_slice(&grid, z, &mut slice);
            }
            slice[(y * i64::from(nx) + x) as usize]
        });
        volume_at(grid.dims(), rows, |p| (*slices.borrow_mut())(p))
    };
    let view = straight.view();
    let mirrored = volume_at(grid.dims(), flipped, |[x, y, z]| {
        view.at([i64::from(nx) - 1 - x, y, z].map(|i| i as u32))
    });
    let volumes = [&straight, &mirrored];
    for table in [
        "{ from = \"anterior\", bone_hu = 250 }",
        "{ from = \"left\", bone_hu = 250 }",
        "{ from = { azimuth_deg = -140, elevation_deg = 25 }, bone_hu = 250 }",
    ] {
        let scene = scene([160, 150], table, "");
        let images = volumes.map(|volume| image(&mut renderer(&scene, volume), &what(volume), &scene));
        let seen = scene.views[0].surface.camera(&grid, scene.views[0].size).unwrap();
        let rows = || (0..150_usize).step_by(2);
        let truth: Vec<Vec<bool>> = rows()
            .map(|y| {
                (0..160)
                    .map(|x| meets_bone(&patient, &seen, [f64::from(x), y as f64], 250.0))
                    .collect()
            })
            .collect();
        let (mut agree, mut all, mut told, mut sides) = (0, 0, 0, 0);
        for (y, row) in rows().zip(&truth) {
            for x in 0..160 {
                let are_right = images.each_ref().map(|image| (image[y * 160 + x] != GROUND) == row[x]);
                all += 2;
                agree += are_right.into_iter().filter(|right| *right).count();
                // Where the patient is not symmetric, a mirrored image is wrong.
                if row[x] != row[159 - x] {
                    sides += 2;
                    told += are_right.into_iter().filter(|right| *right).count();
                }
            }
        }
        // Pixels of 2.5 mm: those beside an outline may be off.
        assert!(agree * 100 > all * 96, "{table}: {agree} of {all}");
        assert!(sides > 200 && told * 100 > sides * 80, "{table}: {told} of {sides}");
    }
}

fn patient_slice(grid: &geometry::VolumeGrid, z: i64, slice: &mut [i16]) {
    Phantom::new(1).fill_slice(grid, z as u32, slice);
}

/// A wall of bone across y, as large as the volume, 10 mm thick.
fn wall() -> OwnedVolume {
    volume(
        [100, 100, 100],
        |[_, y, _]| if (45..55).contains(&y) { 1000 } else { 0 },
    )
}

/// The tube alone is solid, before bone as well, and in stripes behind it.
#[test]
fn what_is_behind_bone_is_told_as_behind() {
    let scene = scene(
        [150, 150],
        "{ field_mm = 150 }",
        "[tool]\nlength_mm = 60.0\ndiameter_mm = 20.0",
    );
    let volume = wall();
    let mut renderer = renderer(&scene, &volume);
    // Along x, so that it lies across the image; 6 mm about the axis its light is nearly that of its front.
    let mut at = |y: f64| {
        let what = Rendered {
            pose: Some(tube([80.0, y, 50.0], Direction::X)),
            ..what(&volume)
        };
        let image = image(&mut renderer, &what, &scene);
        let seen = scene.views[0]
            .surface
            .camera(&volume.grid, scene.views[0].size)
            .unwrap();
        let inside = |x: f64, z: f64| {
            let p = seen.project(Point::new(x, y, z));
            image[p.y.round() as usize * 150 + p.x.round() as usize]
        };
        let places = (26..72).flat_map(|x| (46..54).map(move |z| (f64::from(x), f64::from(z))));
        let is_tube = |[r, g, b]: [u8; 3]| b > r.saturating_add(30) && g > r && b > 150;
        let pixels: Vec<_> = places.map(|(x, z)| inside(x, z)).collect();
        let of_tube = pixels.iter().filter(|pixel| is_tube(**pixel)).count();
        of_tube as f64 / pixels.len() as f64
    };
    // The viewer is in front: y grows away from her.
    assert_eq!(at(20.0), 1.0);
    let behind = at(80.0);
    assert!((0.4..0.6).contains(&behind), "{behind}");
    // Half sunk into the wall, its front is still before it.
    assert_eq!(at(42.0), 1.0);
    assert!(TUBE[2] > 200);
}

#[test]
fn without_bone_the_image_says_so_and_shows_the_tube_all_the_same() {
    let scene = scene([300, 300], "{ bone_hu = 300 }", "");
    let (air, bone) = (volume([60, 60, 60], |_| -1000), wall());
    let placed = |volume| Rendered {
        pose: Some(tube([30.0, 30.0, 30.0], Direction::Z)),
        ..what(volume)
    };
    let is_warn = |[r, g, b]: &&[u8; 3]| *r > 150 && (90..180).contains(g) && *b < 60;
    let warn = |image: &[[u8; 3]]| image.iter().filter(is_warn).count();
    let of_air = image(&mut renderer(&scene, &air), &placed(&air), &scene);
    let of_bone = image(&mut renderer(&scene, &bone), &placed(&bone), &scene);
    assert!(warn(&of_air) > 40, "{}", warn(&of_air));
    assert_eq!(warn(&of_bone), 0);
    let blue = |image: &[[u8; 3]]| image.iter().filter(|[r, _, b]| *b > r.saturating_add(40)).count();
    assert!(blue(&of_air) > 200);
    assert_eq!(Anatomy::of(&air.view(), 300.0, None, &mut || {}).triangles(), 0);
}

/// Noise in every voxel has more surface than is allowed: refused, and said.
#[test]
fn a_surface_that_is_too_large_is_not_shown_and_said() {
    let noise = volume([180, 180, 100], |p| if common::noise(p) > 0 { 1000 } else { 0 });
    assert_eq!(Anatomy::of(&noise.view(), 300.0, None, &mut || {}).triangles(), 0);
}

#[test]
fn what_is_kept_is_what_would_be_drawn_and_held_images_are_as_the_scene_says() {
    let more = "[[targets]]\nname = \"n\"\nct_mm = [40, 20, 60]\n[[targets]]\nname = \"m\"\nct_mm = [60, 80, 40]\n\
                [[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"";
    let scene = scene([240, 230], "{ from = { azimuth_deg = 20, elevation_deg = 30 } }", more);
    let volume = wall();
    let chosen = Chosen {
        name: "n".to_owned(),
        centre: Point::new(40.0, 20.0, 60.0),
        radius_mm: 2.5,
        entry: Some(Point::new(90.0, 10.0, 60.0)),
        stop_mm: 5.0,
    };
    let of = |i: u32, notice| Rendered {
        pose: Some(tube([30.0 + f64::from(i), 50.0, 50.0], Direction::X)),
        notice,
        chosen: Some(&chosen),
        ..what(&volume)
    };
    let mut kept = renderer(&scene, &volume);
    for i in 0..5 {
        let fresh = image(&mut renderer(&scene, &volume), &of(i, Notice::Live), &scene);
        assert!(image(&mut kept, &of(i, Notice::Live), &scene) == fresh, "{i}");
    }
    let held = image(&mut kept, &of(3, Notice::Requested), &scene);
    let straight = image(&mut kept, &of(3, Notice::Live), &scene);
    let axes = [-Direction::X, -Direction::Z];
    let behind = SlicePlane::centred(volume.grid.centre(), axes, 0.7, [240, 230]).unwrap();
    kept.turn(Some(behind));
    let turned = image(&mut kept, &of(3, Notice::Live), &scene);
    assert!(turned != straight);
    assert!(image(&mut kept, &of(3, Notice::Requested), &scene) == held);
    assert!(image(&mut kept, &of(3, Notice::Live), &scene) == turned);
    kept.turn(None);
    assert!(image(&mut kept, &of(3, Notice::Live), &scene) == straight);
    // Lost: neither tube nor slices, and the same wherever the last pose was.
    let lost = Notice::Lost(Lost::NotSeen, Some(1));
    assert!(image(&mut kept, &of(0, lost), &scene) == image(&mut kept, &of(4, lost), &scene));
}

/// Whatever pose the bus lets through: places up to 100 m away.
#[test]
fn far_poses_and_small_fields_do_no_harm() {
    let volume = wall();
    for field in [10.0, 2000.0] {
        let scene = scene(
            [200, 200],
            &format!("{{ field_mm = {field} }}"),
            "[tool]\nlength_mm = 1000.0",
        );
        let mut renderer = renderer(&scene, &volume);
        for mm in [0.0, 1e3, 1e5, -1e5] {
            for along in [Direction::X, Direction::Y, -Direction::Z] {
                let what = Rendered {
                    pose: Some(tube([mm, -mm, mm], along)),
                    ..what(&volume)
                };
                image(&mut renderer, &what, &scene);
            }
        }
    }
}
