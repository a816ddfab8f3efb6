//! Four cells: energies and forces.

use super::four::{Work, prepare, pressure};
use super::points::stress;
use super::{CELLS, Lane, Material, Table};

/// Energies of the cells, `None` where the law has none.
#[inline(always)]
pub(super) fn energy<W: Lane>(
    proof: W::Proof,
    work: &mut Work<W>,
    table: &Table,
    material: &Material,
    u: &[&[f64]],
) -> [Option<f64>; CELLS] {
    let regular = prepare(proof, work, table, u);
    told(&regular, sum(proof, work, table, material))
}

/// The same, and forces added.
#[inline(always)]
pub(super) fn gradient<W: Lane>(
    proof: W::Proof,
    work: &mut Work<W>,
    table: &Table,
    material: &Material,
    u: &[&[f64]],
    forces: [&mut [f64]; CELLS],
) -> [Option<f64>; CELLS] {
    let regular = prepare(proof, work, table, u);
    let energies = told(&regular, sum(proof, work, table, material));
    // Taken out, as the points are read while forces are written.
    let mut own = std::mem::take(&mut work.forces);
    // Summed apart from the caller's: a cell without an energy must leave those as they are.
    own.clear();
    own.resize(3 * table.nodes(), W::splat(proof, 0.0));
    let (lambda, mu) = (material.lame.lambda, W::splat(proof, material.lame.mu));
    for (point, weight) in table.weights.iter().enumerate() {
        let at = &work.points[point];
        let pressure = pressure(proof, work, table, lambda, point);
        // The derivative by J of `mu (x - ln J)` and of the volume's part, which is the pressure over J.
        let slope = mu.times(at.x).plus(pressure).over(at.j);
        let stress = stress(proof, at, mu, slope, W::splat(proof, *weight));
        scatter(proof, &stress, table.slopes_at(point), &mut own);
    }
    for (lane, (forces, energy)) in forces.into_iter().zip(&energies).enumerate() {
        // Of a cell without an energy nothing is added: its forces may be no numbers.
        if energy.is_some() {
            forces.iter_mut().zip(&own).for_each(|(f, own)| *f += own.lanes()[lane]);
        }
    }
    work.forces = own;
    energies
}

/// `sum_p w_p (mu / 2 q + mu (x - ln J)) + (lambda / 2) int (Pi theta)^2`.
#[inline(always)]
fn sum<W: Lane>(proof: W::Proof, work: &Work<W>, table: &Table, material: &Material) -> W {
    let half = W::splat(proof, 0.5);
    let (mut shear, mut square) = (W::splat(proof, 0.0), W::splat(proof, 0.0));
    for (at, weight) in work.points.iter().zip(&table.weights) {
        let weight = W::splat(proof, *weight);
        shear = shear.plus(weight.times(half.times(at.q).plus(at.rest)));
        square = square.plus(weight.times(at.theta.times(at.theta)));
    }
    // The square of the projection in the place of theta's own.
    if table.mode_count > 0 {
        square = W::splat(proof, 0.0);
        for mean in work.means {
            square = square.plus(mean.times(mean));
        }
        square = square.times(W::splat(proof, table.volume()));
    }
    let volumetric = W::splat(proof, 0.5 * material.lame.lambda).times(square);
    W::splat(proof, material.lame.mu).times(shear).plus(volumetric)
}

fn told(regular: &[bool; CELLS], energies: impl Lane) -> [Option<f64>; CELLS] {
    let lanes = energies.lanes();
    std::array::from_fn(|k| (regular[k] && lanes[k].is_finite()).then_some(lanes[k]))
}

/// `f_ni += P_iJ Q_nJ`.
#[inline(always)]
fn scatter<W: Lane>(proof: W::Proof, p: &[W; 9], slopes: &[[f64; 3]], forces: &mut [W]) {
    for (force, q) in forces.as_chunks_mut::<3>().0.iter_mut().zip(slopes) {
        let [x, y, z] = q.map(|q| W::splat(proof, q));
        for (i, force) in force.iter_mut().enumerate() {
            let part = p[i].times(x).plus(p[i + 3].times(y)).plus(p[i + 6].times(z));
            *force = force.plus(part);
        }
    }
}
