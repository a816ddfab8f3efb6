//! Directions in a graph without places.

use super::super::graph::Graph;

const UNSEEN: u32 = u32::MAX;
/// How often halves are made even and diffused anew.
const ROUNDS: usize = 6;
/// For how many steps: this part of the side of a cube of as many vertices, as a cut that bends little moves by less than a vertex in few.
const STEPS_PER_SIDE: f64 = 0.5;

/// Steps from a vertex to every vertex of its part, in the order in which they are reached.
pub(super) struct Levels<'a> {
    graph: &'a Graph,
    /// Of each vertex: its place in the part, or none.
    number: Vec<u32>,
}

impl<'a> Levels<'a> {
    pub(super) fn new(graph: &'a Graph) -> Self {
        Self {
            graph,
            number: vec![UNSEEN; graph.size()],
        }
    }

    /// The pieces of a part that no edge joins.
    pub(super) fn pieces(&mut self, part: Vec<u32>) -> Vec<Vec<u32>> {
        part.iter().for_each(|i| self.number[*i as usize] = 0);
        let mut pieces = Vec::new();
        for &i in &part {
            if self.number[i as usize] == UNSEEN {
                continue;
            }
            self.number[i as usize] = UNSEEN;
            let (mut piece, mut at) = (vec![i], 0);
            while at < piece.len() {
                for &j in self.graph.of(piece[at] as usize) {
                    if self.number[j as usize] != UNSEEN {
                        self.number[j as usize] = UNSEEN;
                        piece.push(j);
                    }
                }
                at += 1;
            }
            pieces.push(piece);
        }
        if let [_] = pieces[..] {
            // In the order that it came in.
            return vec![part];
        }
        pieces
    }

    /// Three directions in a connected part: differences of the steps to two ends, far from one another.
    pub(super) fn directions(&mut self, part: &[u32]) -> Vec<Vec<f64>> {
        for (k, i) in part.iter().enumerate() {
            self.number[*i as usize] = k as u32;
        }
        let far = |steps: &[u32]| {
            (0..steps.len())
                .max_by_key(|k| (steps[*k], usize::MAX - k))
                .unwrap_or(0)
        };
        let mut directions = Vec::new();
        // The vertex farthest from any, and the one farthest from that, are near the ends (Gibbs, Poole and Stockmeyer 1976).
        let mut least = self.steps(part, far(&self.steps(part, 0)));
        for _ in 0..3 {
            let one = far(&least);
            let from_one = self.steps(part, one);
            let from_other = self.steps(part, far(&from_one));
            let difference = from_one.iter().zip(&from_other);
            let difference = difference.map(|(a, b)| f64::from(*a) - f64::from(*b));
            directions.push(self.straightened(part, difference.collect()));
            // The next direction begins far from all ends so far, so that it leads elsewhere.
            for (k, l) in least.iter_mut().enumerate() {
                *l = (*l).min(from_one[k]).min(from_other[k]);
            }
        }
        part.iter().for_each(|i| self.number[*i as usize] = UNSEEN);
        directions
    }

    /// A direction whose middle is a shorter cut: halves diffuse into one another, which pulls in what juts out of them, and are
    /// made halves again (threshold dynamics of Merriman, Bence and Osher 1992).
    pub(super) fn straight(&mut self, part: &[u32], along: Vec<f64>) -> Vec<f64> {
        for (k, i) in part.iter().enumerate() {
            self.number[*i as usize] = k as u32;
        }
        let straight = self.straightened(part, along);
        part.iter().for_each(|i| self.number[*i as usize] = UNSEEN);
        straight
    }

    fn straightened(&self, part: &[u32], mut along: Vec<f64>) -> Vec<f64> {
        let steps = (STEPS_PER_SIDE * (part.len() as f64).cbrt()).ceil() as usize;
        let mut sorted = Vec::new();
        let mut next = vec![0.0; part.len()];
        for _ in 0..ROUNDS {
            sorted.clone_from(&along);
            sorted.sort_unstable_by(f64::total_cmp);
            // The median: halves stay halves, however far diffusion has moved the values.
            let middle = sorted[sorted.len() / 2];
            along.iter_mut().for_each(|x| *x = if *x < middle { -1.0 } else { 1.0 });
            for _ in 0..steps {
                for (k, next) in next.iter_mut().enumerate() {
                    let near = self.graph.of(part[k] as usize).iter().map(|j| self.number[*j as usize]);
                    // With its own value: else neighbours could exchange theirs at every step and never agree.
                    let (mut sum, mut count) = (along[k], 1.0);
                    for j in near.filter(|j| *j != UNSEEN) {
                        sum += along[j as usize];
                        count += 1.0;
                    }
                    *next = sum / count;
                }
                std::mem::swap(&mut along, &mut next);
            }
        }
        along
    }

    /// Steps from one vertex of the part to each.
    fn steps(&self, part: &[u32], from: usize) -> Vec<u32> {
        let mut steps = vec![UNSEEN; part.len()];
        let (mut reached, mut at) = (vec![from], 0);
        steps[from] = 0;
        while at < reached.len() {
            let k = reached[at];
            for &j in self.graph.of(part[k] as usize) {
                let j = self.number[j as usize];
                if j != UNSEEN && steps[j as usize] == UNSEEN {
                    steps[j as usize] = steps[k] + 1;
                    reached.push(j as usize);
                }
            }
            at += 1;
        }
        steps
    }
}
