//! The largest set of vertices of a graph that are all joined to one another, exactly.

/// A graph on `n` vertices; row `i` holds one bit per neighbour.
pub(super) struct Graph {
    rows: Vec<Bits>,
}

/// A set of vertices.
#[derive(Clone)]
struct Bits(Vec<u64>);

impl Bits {
    fn none(n: usize) -> Self {
        Self(vec![0; n.div_ceil(64)])
    }

    fn insert(&mut self, i: usize) {
        self.0[i / 64] |= 1 << (i % 64);
    }

    fn remove(&mut self, i: usize) {
        self.0[i / 64] &= !(1 << (i % 64));
    }

    fn and(&self, other: &Self) -> Self {
        Self(self.0.iter().zip(&other.0).map(|(a, b)| a & b).collect())
    }

    fn subtract(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a &= !b);
    }

    fn count(&self) -> u32 {
        self.0.iter().map(|w| w.count_ones()).sum()
    }

    fn first(&self) -> Option<usize> {
        let word = self.0.iter().position(|w| *w != 0)?;
        Some(word * 64 + self.0[word].trailing_zeros() as usize)
    }
}

impl Graph {
    /// The graph that joins `i < j` where `joined(i, j)`.
    pub(super) fn new(n: usize, joined: impl Fn(usize, usize) -> bool) -> Self {
        let mut rows = vec![Bits::none(n); n];
        for i in 0..n {
            for j in i + 1..n {
                if joined(i, j) {
                    rows[i].insert(j);
                    rows[j].insert(i);
                }
            }
        }
        Self { rows }
    }

    /// A largest clique, ascending; or `Err(steps)` where `max_steps` branches did not settle it.
    ///
    /// Branch and bound with the bound of a greedy colouring (Tomita and Seki 2003). Deterministic.
    pub(super) fn largest_clique(&self, max_steps: usize) -> Result<Vec<usize>, usize> {
        let n = self.rows.len();
        let mut all = Bits::none(n);
        (0..n).for_each(|i| all.insert(i));
        let mut search = Search {
            graph: self,
            best: Vec::new(),
            current: Vec::new(),
            steps: 0,
            max_steps,
        };
        search.expand(all);
        if search.steps > max_steps {
            return Err(max_steps);
        }
        search.best.sort_unstable();
        Ok(search.best)
    }
}

struct Search<'a> {
    graph: &'a Graph,
    best: Vec<usize>,
    current: Vec<usize>,
    steps: usize,
    max_steps: usize,
}

impl Search<'_> {
    fn expand(&mut self, mut candidates: Bits) {
        if self.current.len() > self.best.len() {
            self.best.clone_from(&self.current);
        }
        // The last colour first: it bounds what the rest can still add.
        for (vertex, colours) in self.coloured(&candidates).into_iter().rev() {
            self.steps += 1;
            // Of each colour a clique has one member at most. What is left of the list has no higher colour, so that
            // not this vertex alone is bounded but all that follow; past the last step the recursion only unwinds.
            if self.current.len() + colours <= self.best.len() || self.steps > self.max_steps {
                return;
            }
            self.current.push(vertex);
            self.expand(candidates.and(&self.graph.rows[vertex]));
            self.current.pop();
            candidates.remove(vertex);
        }
    }

    /// The candidates by colour, neighbours never sharing one, each with its colour counted from 1.
    fn coloured(&self, candidates: &Bits) -> Vec<(usize, usize)> {
        let mut order = Vec::with_capacity(candidates.count() as usize);
        let mut left = candidates.clone();
        let mut colour = 0;
        while left.first().is_some() {
            colour += 1;
            let mut class = left.clone();
            while let Some(vertex) = class.first() {
                class.remove(vertex);
                // A colour class is an independent set: neighbours of a member have to wait for the next colour.
                class.subtract(&self.graph.rows[vertex]);
                left.remove(vertex);
                order.push((vertex, colour));
            }
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By trying all subsets.
    fn brute(n: usize, joined: impl Fn(usize, usize) -> bool) -> usize {
        let clique = |set: u32| {
            let inside = |i: &usize| set >> i & 1 == 1;
            let members: Vec<usize> = (0..n).filter(inside).collect();
            let all = members.iter().all(|&i| members.iter().all(|&j| i >= j || joined(i, j)));
            if all { members.len() } else { 0 }
        };
        (0..1_u32 << n).map(clique).max().unwrap()
    }

    #[test]
    fn agrees_with_trying_all_subsets() {
        for seed in 0..40_usize {
            let joined =
                |i: usize, j: usize| (i * 7919 + j * 104_729 + seed * 31_337).wrapping_mul(2_654_435_761) >> 9 & 3 != 0;
            let found = Graph::new(12, joined).largest_clique(1 << 20).unwrap();
            assert_eq!(found.len(), brute(12, joined), "seed {seed}");
            assert!(found.windows(2).all(|w| joined(w[0], w[1])));
        }
    }

    #[test]
    fn gives_up_with_the_number_of_steps() {
        assert_eq!(Graph::new(80, |i, j| i % 4 != j % 4).largest_clique(3), Err(3));
    }
}
