//! Images without bone: no line may be told.

use chance::Chance;
use echo::bone::{BoneError, BoneLine, Options, Verdict, find};
use ultrasound::{Beams, Shape};

use super::scan::{Depth, Scene, convex, image, keep, linear, of};

fn line(shape: &Shape, grey: &[u8]) -> BoneLine {
    find(&of(shape, grey), &Options::default()).unwrap()
}

/// How many of some scenes have a line, of how many.
fn false_lines(name: &str, change: &dyn Fn(&mut Scene<'_>)) -> (usize, usize) {
    let (mut told, mut all) = (0, 0);
    for shape in [linear(), convex()] {
        for seed in 0..3 {
            let mut scene = Scene {
                seed: 100 + seed,
                ..Scene::default()
            };
            change(&mut scene);
            let grey = image(&shape, &scene);
            let found = line(&shape, &grey);
            keep(&shape, &grey, &found, &format!("no-{name}-{seed}-{}", shape.columns()));
            assert_eq!(found.points.is_empty(), found.reason().is_some());
            told += usize::from(!found.points.is_empty());
            all += 1;
            if seed == 0 {
                println!(
                    "{name}: {}",
                    found.reason().unwrap_or_else(|| format!("TOLD: {:?}", found.ridges))
                );
            }
        }
    }
    println!("{name}: {told} false of {all} images");
    (told, all)
}

const FIRST: &Depth<'static> = &|share| Some(8.0 + 1.5 * share + (9.0 * share).sin() * 0.6);
const SECOND: &Depth<'static> = &|share| if share > 0.4 { Some(14.0 - 1.2 * share) } else { None };
const BOW: &Depth<'static> = &|share| Some(22.0 + 20.0 * (share - 0.5) * (share - 0.5));
const LEANING: &Depth<'static> = &|share| Some(12.0 + 14.0 * share);

#[test]
fn no_line_is_told_where_there_is_no_bone() {
    let mut told = 0;
    let mut hold = |name: &str, change: &dyn Fn(&mut Scene<'_>)| told += false_lines(name, change).0;
    hold("speckle", &|_| {});
    hold("one fascia", &|scene| scene.fascias = &[(BOW, 80.0)]);
    hold("fascia as bright as bone", &|scene| scene.fascias = &[(BOW, 40.0)]);
    hold("three fascias", &|scene| {
        scene.fascias = &[(FIRST, 70.0), (SECOND, 55.0), (BOW, 90.0)]
    });
    hold("a leaning fascia", &|scene| scene.fascias = &[(LEANING, 80.0)]);
    hold("a fascia where all fades", &|scene| {
        (scene.fascias, scene.fade) = (&[(BOW, 80.0)], 0.6);
    });
    hold("a fascia where all fades fast", &|scene| {
        (scene.fascias, scene.fade) = (&[(BOW, 80.0)], 1.2);
    });
    hold("a fascia over darker tissue", &|scene| {
        (scene.fascias, scene.layer) = (&[(BOW, 80.0)], Some((23.0, 8.0)));
    });
    hold("high gain", &|scene| {
        (scene.fascias, scene.tissue) = (&[(BOW, 80.0)], 160.0)
    });
    hold("low gain", &|scene| {
        (scene.fascias, scene.tissue) = (&[(BOW, 80.0)], 20.0)
    });
    hold("noise alone", &|scene| (scene.tissue, scene.noise) = (-200.0, 60.0));
    assert_eq!(told, 0);
}

/// What cannot be told apart: below this fascia there is nothing to see, as below bone. Pinned, so that it is known.
#[test]
fn a_fascia_over_what_does_not_scatter_at_all_looks_like_bone() {
    let (told, all) = false_lines("a fascia over a silent layer", &|scene| {
        (scene.fascias, scene.layer) = (&[(BOW, 80.0)], Some((23.0, 40.0)));
    });
    assert!(
        told > 0,
        "{told} of {all}: it is told apart by now, so say so in docs/bone-line.md"
    );
}

#[test]
fn images_of_one_grey_and_of_stripes_have_no_line() {
    for shape in [linear(), convex()] {
        for grey in [0, 1, 128, 255] {
            let found = line(&shape, &vec![grey; shape.columns() * shape.rows()]);
            assert!(found.points.is_empty() && found.ridges.is_empty());
            assert_eq!(found.reason().unwrap(), "no line in it is bright and long enough");
        }
        let chance = Chance::new(5, 6);
        let pixels = shape.columns() * shape.rows();
        let noise: Vec<u8> = (0..pixels as u64).map(|i| (255.0 * chance.uniform(i)) as u8).collect();
        assert!(line(&shape, &noise).points.is_empty());
        let stripes: Vec<u8> = (0..pixels)
            .map(|i| if (i / shape.columns()) % 60 < 5 { 255 } else { 0 })
            .collect();
        assert!(line(&shape, &stripes).points.is_empty());
    }
    // One bright line with nothing above and below, as a caliper drawn into the image or a wall in water.
    let shape = linear();
    let drawn: Vec<u8> = (0..220_000)
        .map(|i| if (200..206).contains(&(i / 440)) { 255 } else { 0 })
        .collect();
    let found = line(&shape, &drawn);
    assert!(found.ridges.iter().any(|ridge| ridge.verdict == Verdict::NothingToMiss));
    assert!(found.reason().unwrap().contains("no tissue"));
}

#[test]
fn what_cannot_be_searched_is_refused_by_name() {
    let shape = linear();
    let grey = vec![0; 220_000];
    let said = |options: &Options| find(&of(&shape, &grey), options).unwrap_err().to_string();
    let default = Options::default();
    for value in [f64::NAN, f64::INFINITY, -1.0, 1e9] {
        assert!(
            said(&Options {
                axial_mm: value,
                ..default
            })
            .contains("the smoothing along the beam, mm")
        );
        assert!(
            said(&Options {
                min_shadow_share: value,
                ..default
            })
            .contains("the share with a shadow")
        );
        assert!(
            said(&Options {
                black: value,
                ..default
            })
            .contains("the grey of silence")
        );
    }
    let beams = Beams::Linear {
        from_mm: 0.0,
        to_mm: 20.0,
        face_mm: 0.0,
    };
    let shallow = Shape::new([200, 200], [0.1, 0.1], beams, 12.0).unwrap();
    let found = find(&of(&shallow, &vec![0; 40_000]), &default);
    assert_eq!(
        found,
        Err(BoneError::Shallow {
            found: 12.0,
            needed: 18.0
        })
    );
    let beams = Beams::Linear {
        from_mm: 0.0,
        to_mm: 390.0,
        face_mm: 0.0,
    };
    let large = Shape::new([4096, 4096], [0.1, 0.1], beams, 400.0).unwrap();
    let options = Options {
        spacing_mm: 0.05,
        ..default
    };
    let found = find(&of(&large, &vec![0; 4096 * 4096]), &options);
    assert_eq!(found, Err(BoneError::Dense { spacing_mm: 0.05 }));
    // Beams that leave the image on all sides.
    let beams = Beams::Convex {
        centre_mm: [900.0, 900.0],
        radius_mm: 50.0,
        half_angle: 1.5,
    };
    let outside = Shape::new([64, 64], [0.1, 0.1], beams, 60.0).unwrap();
    assert!(find(&of(&outside, &[200; 4096]), &default).unwrap().points.is_empty());
}
