//! Tests of whole answers.

use geometry::Point;

#[test]
#[ignore]
fn explore() {
    let patient = phantom::Phantom::new(1);
    println!("{:?} {:?}", patient.approach(), patient.targets());
    let (mut low, mut high) = ([1e9_f64; 3], [-1e9_f64; 3]);
    for x in 0..120 {
        for y in 0..120 {
            for z in 0..180 {
                let p = [f64::from(x), f64::from(y), f64::from(z) + 30.0];
                if patient.structure(Point::new(p[0], p[1], p[2])) == 3 {
                    for a in 0..3 {
                        low[a] = low[a].min(p[a]);
                        high[a] = high[a].max(p[a]);
                    }
                }
            }
        }
    }
    println!("{low:?} {high:?}");
    for z in [74, 76, 78, 80, 82, 84, 88, 92] {
        let mut b = [1e9_f64, -1e9, 1e9, -1e9];
        for x in 0..120 {
            for y in 0..120 {
                let p = [f64::from(x), f64::from(y), f64::from(z)];
                if patient.structure(Point::new(p[0], p[1], p[2])) == 3 {
                    b = [b[0].min(p[0]), b[1].max(p[0]), b[2].min(p[1]), b[3].max(p[1])];
                }
            }
        }
        println!("{z}: {b:?}");
    }
}
