//! What the errors that are stated are attacked with: lenses, sheets, light and blur that no model has.

use crate::common::Random;
use crate::common::lens_scene::{Glass, LensScene, Seen};
use crate::lens::{HEAD, of};

/// What the stated errors are attacked with.
fn attacks() -> Vec<(&'static str, LensScene)> {
    let glass = |radial: [f64; 3]| Glass {
        radial,
        ..Glass::default()
    };
    let base = || LensScene {
        glass: glass([-0.2, 0.0, 0.0]),
        ..LensScene::default()
    };
    let bent = |along, across, twist| LensScene {
        bow_mm: [along, across, twist],
        ..LensScene::default()
    };
    vec![
        (
            "k1 -0.01",
            LensScene {
                glass: glass([-0.01, 0.0, 0.0]),
                ..base()
            },
        ),
        (
            "k1 0.003",
            LensScene {
                glass: glass([0.003, 0.0, 0.0]),
                ..base()
            },
        ),
        (
            "k1 0.001",
            LensScene {
                glass: glass([0.001, 0.0, 0.0]),
                ..base()
            },
        ),
        (
            "k1 0.0003",
            LensScene {
                glass: glass([0.0003, 0.0, 0.0]),
                ..base()
            },
        ),
        (
            "aside 0.1 0.05",
            LensScene {
                glass: Glass {
                    aside: [0.1, 0.05],
                    ..glass([-0.3, 0.0, 0.0])
                },
                ..base()
            },
        ),
        (
            "aside 0.25",
            LensScene {
                glass: Glass {
                    aside: [0.25, -0.1],
                    ..glass([-0.2, 0.0, 0.0])
                },
                ..base()
            },
        ),
        (
            "tangential",
            LensScene {
                glass: Glass {
                    tangential: [0.02, -0.01],
                    ..glass([-0.2, 0.0, 0.0])
                },
                ..base()
            },
        ),
        (
            "tangential alone",
            LensScene {
                glass: Glass {
                    tangential: [0.01, 0.01],
                    ..Glass::default()
                },
                ..base()
            },
        ),
        (
            "k2",
            LensScene {
                glass: glass([-0.3, 0.3, 0.0]),
                ..base()
            },
        ),
        (
            "k2 k3",
            LensScene {
                glass: glass([0.2, -0.4, 0.3]),
                ..base()
            },
        ),
        (
            "fisheye",
            LensScene {
                glass: Glass {
                    fisheye: true,
                    ..Glass::default()
                },
                ..base()
            },
        ),
        ("bow 1", bent(1.0, 0.0, 0.0)),
        ("bow 4", bent(4.0, 0.0, 0.0)),
        ("bow 12", bent(12.0, -3.0, 0.0)),
        ("twist 3", bent(0.0, 0.0, 3.0)),
        (
            "bow 2 and lens",
            LensScene {
                bow_mm: [0.0, 2.0, 1.0],
                ..base()
            },
        ),
        (
            "rolling blur",
            LensScene {
                blur: 1.2,
                blur_slope: 0.6,
                ..base()
            },
        ),
        (
            "rolling blur, no lens",
            LensScene {
                blur: 1.2,
                blur_slope: 0.6,
                glass: glass([0.0; 3]),
                ..base()
            },
        ),
        (
            "vignette",
            LensScene {
                vignette: 0.5,
                ..base()
            },
        ),
        (
            "vignette, no lens",
            LensScene {
                vignette: 0.5,
                glass: glass([0.0; 3]),
                ..base()
            },
        ),
        ("noise 0.1", LensScene { noise: 0.1, ..base() }),
        (
            "noise 0.1, no lens",
            LensScene {
                noise: 0.1,
                glass: glass([0.0; 3]),
                ..base()
            },
        ),
        (
            "noise 0.1, blur 0.5",
            LensScene {
                noise: 0.1,
                blur: 0.5,
                ..base()
            },
        ),
        (
            "noise 0.1, blur 0.5, no lens",
            LensScene {
                noise: 0.1,
                blur: 0.5,
                glass: glass([0.0; 3]),
                ..base()
            },
        ),
        ("noise 20", LensScene { noise: 20.0, ..base() }),
        (
            "in a corner",
            LensScene {
                within: [20.0, 20.0, 240.0, 240.0],
                glass: glass([-0.4, 0.0, 0.0]),
                ..base()
            },
        ),
        (
            "in a corner, no lens",
            LensScene {
                within: [20.0, 20.0, 240.0, 240.0],
                glass: glass([0.0; 3]),
                ..base()
            },
        ),
        (
            "large discs",
            LensScene {
                radius: 7.0,
                glass: glass([-0.4, 0.0, 0.0]),
                ..base()
            },
        ),
        ("small discs", LensScene { radius: 1.5, ..base() }),
        ("paper ends close by", LensScene { rim: 0.5, ..base() }),
        (
            "paper ends close by, no lens",
            LensScene {
                rim: 0.5,
                glass: glass([0.0; 3]),
                ..base()
            },
        ),
        (
            "missing",
            LensScene {
                hidden: (0..16).map(|k| [k * 7 % 10, k * 3 % 9]).collect(),
                ..base()
            },
        ),
        (
            "all at once",
            LensScene {
                glass: Glass {
                    radial: [-0.25, 0.1, 0.0],
                    tangential: [0.005, 0.003],
                    aside: [0.05, 0.02],
                    fisheye: false,
                },
                bow_mm: [1.0, 0.0, 0.5],
                vignette: 0.3,
                blur_slope: 0.3,
                ..base()
            },
        ),
    ]
}

/// Each attack at three tilts, `count` images each.
pub(crate) fn attacked(python: Option<&str>, first: u64, count: u64, only: Option<&str>) {
    println!("{HEAD}");
    for (name, scene) in attacks() {
        if only.is_some_and(|o| !name.contains(o)) {
            continue;
        }
        for tilt_deg in [0.0, 35.0, 60.0] {
            let one = |seed: u64| {
                let roll_deg = 180.0 * Random::new(seed + 31).signed();
                LensScene {
                    tilt_deg,
                    roll_deg,
                    seed,
                    ..scene.clone()
                }
                .draw()
            };
            let seen: Vec<Seen> = (first..first + count).map(one).collect();
            println!("{name:28} {tilt_deg:3}: {}", of(&seen, python).line());
        }
    }
}
