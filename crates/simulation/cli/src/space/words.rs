//! What is said of a scene in space: all that it models, and what it does not.

use std::fmt::Write;

use nalgebra::Vector3;
use organs::hold::How;
use organs::{Labels, Model, Plan};
use simulation::space::cells::{Field, LabelField};

use super::errors::{Finer, Said};
use super::run::Run;

fn line(text: &mut String, head: &str, words: &str) {
    // A String takes all that is written to it.
    let _ = writeln!(text, "{head:<11}{words}");
}

/// The scene alone, where its label map is not read.
pub(super) fn planned(title: &str, plan: &Plan) -> String {
    let mut text = format!("{title}\n");
    line(
        &mut text,
        "space",
        "lengths in mm, stresses in N/mm2, places LPS; no friction, no weight",
    );
    line(&mut text, "unknowns", "not counted: the label map is not read");
    for organ in &plan.organs {
        line(&mut text, "organ", &format!("{}: label {}", organ.name, organ.label));
    }
    text
}

/// The model.
pub(super) fn described(title: &str, path: &str, plan: &Plan, labels: &Labels, model: &Model) -> String {
    let mut text = format!("{title}\n");
    let [all, free] = model.unknowns();
    let ([a, b, c], s) = (labels.size, labels.spacing);
    line(
        &mut text,
        "space",
        "lengths in mm, stresses in N/mm2, places LPS; no friction, no weight",
    );
    line(
        &mut text,
        "labels",
        &format!("{path}: {a} x {b} x {c} voxels of {} x {} x {} mm", s.x, s.y, s.z),
    );
    line(&mut text, "unknowns", &format!("{all}, of which {free} free"));
    for (body, organ) in model.bodies.iter().zip(&plan.organs) {
        let facts = &body.facts;
        let mut words = format!(
            "{}: label {}, {} voxels, {:.1} ml; {} cubes with {} nodes, {:.2} ml; {}{}, E {} N/mm2, nu {:.4}",
            body.name,
            body.label,
            facts.voxels - if facts.filled { facts.holes } else { 0 },
            1e-3 * facts.volume,
            body.mesh.elements.len(),
            body.mesh.nodes.len(),
            1e-3 * body.mesh.volume(),
            organ.law,
            terms(organ.ogden.as_deref()),
            organ.young.value,
            organ.poisson.value
        );
        if facts.dropped > 0 {
            let _ = write!(words, "; {} voxels of other parts are DROPPED", facts.dropped);
        }
        if facts.holes > 0 {
            let what = if facts.filled { "filled" } else { "left open" };
            let _ = write!(words, "; {} voxels of holes are {what}", facts.holes);
        }
        if facts.moved != [0; 2] {
            let [away, taken] = facts.moved;
            let _ = write!(
                words,
                "; smoothing left {away} voxels outside and took {taken} others in"
            );
        }
        if facts.cut.iter().flatten().any(|cut| *cut) {
            let _ = write!(words, "; CUT OFF by the border of the label map");
        }
        line(&mut text, "organ", &words);
    }
    for held in &model.held {
        let name = &model.bodies[held.body].name;
        let words = match held.how {
            How::Nodes(count) => format!("{name}: {count} nodes keep their place ({})", held.by),
            How::Springs {
                points,
                area,
                stiffness,
                ..
            } => {
                format!(
                    "{name}: springs of {stiffness:.3e} N/mm3 at {points} points, {area:.0} mm2 ({})",
                    held.by
                )
            }
        };
        line(&mut text, "held", &words);
    }
    for (contact, obstacle) in plan.contacts.iter().zip(&model.obstacles) {
        let words = format!(
            "{}: kept out of {}, smoothed by {} mm and taken back by {:.2} mm, where it overlaps as it lies; smoothing left {} voxels outside and took {} others in; looked for {:.0} mm round it; it slides",
            model.bodies[contact.organ].name,
            obstacle.by,
            contact.smoothing,
            obstacle.receded_mm,
            obstacle.moved[0],
            obstacle.moved[1],
            obstacle.reach_mm
        );
        line(&mut text, "contact", &words);
    }
    let (way, first) = (&plan.way, plan.way.tip(model.free));
    let words = format!(
        "{} mm wide, round, first touches with its tip at ({:.2}, {:.2}, {:.2}), {:.2} mm from the entry; {} states over {} mm, at most {} mm apart",
        2.0 * way.radius,
        first.x,
        first.y,
        first.z,
        model.free,
        way.strokes().len(),
        way.stroke,
        way.step
    );
    line(&mut text, "tube", &words);
    for target in &model.targets {
        let (at, organ) = (&target.at, &model.bodies[target.body].name);
        let words = format!("{} at ({:.2}, {:.2}, {:.2}), in {organ}", target.name, at.x, at.y, at.z);
        line(&mut text, "target", &words);
    }
    for one in plan.uncertain() {
        let [up, down] = one.moved;
        line(
            &mut text,
            "uncertain",
            &format!("{}: {}, {down:.4e} to {up:.4e}", one.key, one.value),
        );
    }
    for words in warnings(plan, model) {
        line(&mut text, "WARNING", &words);
    }
    for words in not_modelled(plan, labels, model) {
        line(&mut text, "not", &words);
    }
    text
}

/// What a person should look at.
pub(super) fn warnings(plan: &Plan, model: &Model) -> Vec<String> {
    let each = model.overlaps.iter().map(|overlap| {
        let [i, j] = overlap.attachments;
        format!(
            "attachments.{i} and attachments.{j} both hold {} points, {:.0} mm2, of {:?}: what they do adds up there",
            overlap.points, overlap.area, plan.organs[plan.attachments[i].organ].name
        )
    });
    let cut = model
        .bodies
        .iter()
        .filter(|body| body.facts.cut.iter().flatten().any(|cut| *cut));
    let cut = cut.map(|body| {
        format!(
            "{:?} is CUT OFF by the border of the label map: it ends there in a cap that is not the patient's",
            body.name
        )
    });
    each.chain(cut).chain(left_out(plan, model)).collect()
}

/// What contacts leave out.
fn left_out(plan: &Plan, model: &Model) -> Vec<String> {
    let each = plan.contacts.iter().zip(&model.obstacles);
    let each = each.filter_map(|(contact, obstacle)| {
        let left = obstacle.left_out?;
        let [x, y, z] = left.at;
        Some(format!(
            "{:?}: {:.0} mm2 of {} within {:.0} mm of it are thinner or sharper than a ball of {} mm, the nearest {:.1} mm from it at rest, at ({x:.1}, {y:.1}, {z:.1}): a state that comes to them is refused",
            model.bodies[contact.organ].name, left.area, obstacle.by, obstacle.reach_mm, contact.ball, left.apart
        ))
    });
    each.collect()
}

/// What a person might take for modelled and is not.
pub(super) fn not_modelled(plan: &Plan, labels: &Labels, model: &Model) -> Vec<String> {
    let mut all =
        vec!["friction, weight, blood, cutting, and the tissue around the organs but for its springs".to_owned()];
    if model.bodies.len() > 1 {
        all.push("contact of organs with one another: they pass through one another".to_owned());
    }
    all.extend(no_obstacle(plan));
    let others = passed(plan, labels, model);
    if !others.is_empty() {
        all.push(format!("labels that the tube passes through as through air: {others}"));
    }
    all
}

/// What is rigid and stops neither tube nor all organs.
fn no_obstacle(plan: &Plan) -> Vec<String> {
    let names = |of: &dyn Fn(usize) -> bool| -> Vec<&str> {
        let rigid = plan.rigid.iter().enumerate().filter(|(k, _)| of(*k));
        rigid.map(|(_, rigid)| rigid.name.as_str()).collect()
    };
    let is_met = |k: usize| plan.contacts.iter().any(|contact| contact.with.contains(&k));
    let (met, others) = (names(&is_met), names(&|k| !is_met(k)));
    let mut all = Vec::new();
    if !others.is_empty() {
        let names = others.join(", ");
        all.push(format!(
            "contact with what is rigid ({names}): it holds and is no obstacle, to organs and tube"
        ));
    }
    if !met.is_empty() {
        let names = met.join(", ");
        all.push(format!(
            "contact of the tube with what keeps organs out ({names}), and of organs that no contact names"
        ));
    }
    all
}

/// Labels that the tube passes through and that are no part of a meshed organ, with their names where the scene has one: of every voxel whose middle the
/// tube comes over, however thin a wall they are.
fn passed(plan: &Plan, labels: &Labels, model: &Model) -> String {
    let (way, last) = (&model.way, model.free + model.way.stroke);
    // Where a tube is thinner than a voxel its axis lies in one whose middle is no farther than half a diagonal.
    let (reach, end) = (way.radius.max(0.5 * labels.spacing.norm()), last - way.radius);
    let (tip, tail) = (way.tip(end), way.tip(-way.length));
    let corners = [tip.inf(&tail).add_scalar(-reach), tip.sup(&tail).add_scalar(reach)];
    let mut found = std::collections::BTreeSet::new();
    labels.each([&corners[0], &corners[1]], &mut |at, label| {
        if label == 0 || found.contains(&label) || way.off_axis(&at, end) > reach {
            return;
        }
        // Of an organ's label what smoothing took away, or another part of it, is passed through too.
        let is_meshed = |b: &organs::Body| b.label == label && is_at(&b.field, &at, &labels.spacing);
        if !model.bodies.iter().any(is_meshed) {
            found.insert(label);
        }
    });
    let name = |label: &u16| match plan.rigid.iter().find(|r| r.labels.contains(label)) {
        Some(rigid) => format!("{label} ({})", rigid.name),
        None => label.to_string(),
    };
    found.iter().map(name).collect::<Vec<_>>().join(", ")
}

/// True in a region, and where its smooth surface is less than a voxel away from its label's steps.
fn is_at(field: &LabelField, at: &Vector3<f64>, spacing: &Vector3<f64>) -> bool {
    let near = |k: usize| {
        let mut place = *at;
        place[k / 2] += if k.is_multiple_of(2) { 1.0 } else { -1.0 } * spacing[k / 2];
        field.value(&place) < 0.0
    };
    field.value(at) < 0.0 || (0..6).any(near)
}

/// What a whole run says: the worst of each number.
pub(super) fn found(run: &Run) -> String {
    let all = || run.states.iter().filter_map(|s| s.found.as_ref().map(|f| (s, f)));
    let most = all()
        .map(|(_, f)| super::run::beside(f.residual, f.load))
        .fold(0.0, f64::max);
    let depth = all().map(|(_, f)| f.depth).fold(0.0, f64::max);
    let least = all().map(|(_, f)| f.least_determinant).fold(f64::INFINITY, f64::min);
    let balance = all().map(|(s, _)| s.balance).fold(0.0, f64::max);
    let force = all().next_back().map_or(0.0, |(s, _)| s.on_tube.force.norm());
    format!(
        "{} equilibria: free force up to {most:.1e} of the load, depth up to {depth:.1e} mm, balance to {balance:.1e}, least det F {least:.3}; last force {force:.4} N",
        all().count()
    )
}

/// What is said of the errors of the last state: a line for each part and target.
pub(super) fn errors(said: &Said, model: &Model) -> String {
    let errors = match said {
        Said::NotAsked => return "errors of mesh and model not known: not asked for (--errors)\n".to_owned(),
        Said::NotYet => return "errors not looked for yet\n".to_owned(),
        Said::NotKnown(why) => return format!("errors not known: {why}\n"),
        Said::Found(errors) => errors,
    };
    let mut text = String::new();
    let targets = model.targets.iter().enumerate();
    let mut all: Vec<(&str, Option<usize>)> = targets.map(|(k, t)| (t.name.as_str(), Some(k))).collect();
    all.push(("force", None));
    for (name, k) in all {
        let unit = if k.is_some() { "mm" } else { "N" };
        let number = |x: Option<f64>| {
            x.filter(|x| x.is_finite())
                .map_or("NOT KNOWN".to_owned(), |x| format!("{x:.2e} {unit}"))
        };
        let algebraic = errors.left_over(k);
        let mesh = errors.finer.as_ref().ok().map(|found| Finer::stated(&found.by.at(k)));
        let spread = k.map_or(&errors.model.force, |k| &errors.model.targets[k]);
        let bent = spread.is_some_and(|s| !s.is_linear(algebraic.unwrap_or(0.0)));
        let words = format!(
            "algebraic {}, mesh (estimate) {}, model {}{}",
            number(algebraic),
            number(mesh),
            number(spread.map(|s| s.ellipsoid()[0].0)),
            if bent { ", NOT LINEAR in its numbers" } else { "" }
        );
        line(&mut text, "error", &format!("{name}: {words}"));
    }
    for why in errors.model.not_known() {
        line(&mut text, "not known", &format!("model: {why}"));
    }
    if let Err(why) = errors.algebraic.as_ref().and_then(|found| found.further.as_ref()) {
        line(&mut text, "not known", &format!("algebraic: {why}"));
    }
    if let Err(why) = &errors.finer {
        line(&mut text, "not known", &format!("mesh: {why}"));
    }
    line(
        &mut text,
        "",
        "model: the longest half axis of 95 %, by numbers with a standard deviation alone, to first order",
    );
    text
}

/// Terms of an Ogden law, as the scene has them.
fn terms(ogden: Option<&[[f64; 2]]>) -> String {
    ogden.map(|terms| format!(" {terms:?}")).unwrap_or_default()
}
