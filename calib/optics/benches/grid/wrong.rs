//! Many images at random, and whether a column or a row is ever wrong.

use optics::grid::find;

use crate::common::Random;
use crate::common::grid_series::{Scene, Sheet, draw};
use crate::{cpu_ms, errors, spec};

fn scene(seed: u64) -> Scene {
    let mut random = Random::new(seed + 77);
    let mut place = |n: f64| (n * random.unit()) as usize;
    let hidden = (0..place(9.0)).map(|_| [place(10.0), place(10.0)]).collect();
    let spots = place(7.0);
    let spots = (0..spots).map(|_| {
        [
            12.0 * random.unit() - 1.5,
            12.0 * random.unit() - 1.5,
            0.08 + 0.2 * random.unit(),
        ]
    });
    let sheet = Sheet {
        hidden,
        spots: spots.collect(),
        ..Sheet::default()
    };
    Scene {
        tilt_deg: 84.0 * random.unit(),
        roll_deg: 180.0 * random.signed(),
        noise: 2.0 + 23.0 * random.unit(),
        seed,
        sheet,
        ..Scene::default()
    }
}

/// Images `first` to `first + count`: 0 to 8 discs missing, 0 to 6 false ones, tilt 0 to 84 degrees, noise 2 to 25.
pub(crate) fn run(first: u64, count: u64) {
    let (mut found, mut wrong) = (0, 0);
    for seed in first..first + count {
        let scene = scene(seed);
        let drawn = draw(&scene);
        if let Ok(grid) = find(&drawn.image, &spec()) {
            found += 1;
            if errors(&grid, &drawn)[1] > 0.5 * drawn.least_pitch {
                wrong += 1;
                println!("wrong: {scene:?}");
            }
        }
        if (seed + 1 - first).is_multiple_of(250) {
            println!(
                "{} images: {found} grids found, {wrong} with a wrong column or row",
                seed + 1 - first
            );
        }
    }
    println!("{count} images: {found} grids found, {wrong} with a wrong column or row");
}

/// What is found in the same images, for comparison with another build: CPU time, and each disc.
pub(crate) fn dump(first: u64, count: u64) {
    for seed in first..first + count {
        let drawn = draw(&scene(seed));
        let start = cpu_ms();
        let found = find(&drawn.image, &spec());
        println!("image {seed}: {:.1} ms", cpu_ms() - start);
        match found {
            Ok(grid) => grid
                .discs
                .iter()
                .for_each(|d| println!("{} {} {:.12} {:.12}", d.col, d.row, d.at.x, d.at.y)),
            Err(refused) => println!("{refused}"),
        }
    }
}
