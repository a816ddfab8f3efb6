//! An order of elimination that fills little: minimum degree on the quotient graph.

use super::super::graph::Graph;

/// A variable's place in the quotient graph (Amestoy, Davis and Duff 1996).
struct Quotient {
    /// Unknowns that a variable stands for; 0 once it is eliminated or joined to another.
    weight: Vec<usize>,
    /// Vertices that a variable stands for.
    stands_for: Vec<Vec<u32>>,
    variables: Vec<Vec<u32>>,
    elements: Vec<Vec<u32>>,
    /// The variables of the element that an eliminated variable became; empty once absorbed.
    members: Vec<Vec<u32>>,
    /// Unknowns of each element.
    size: Vec<usize>,
    degree: Vec<usize>,
    /// No degree is larger.
    most: usize,
    /// Variables that count in degrees and are never eliminated.
    kept: Vec<bool>,
    mark: Vec<u32>,
    stamp: u32,
    /// `|L_e \ L_p|` of the elements met at this step.
    outside: Vec<usize>,
    seen: Vec<u32>,
}

/// An order of elimination of the vertices of a graph, each of a weight: the k-th vertex eliminated. Those that become
/// alike on the way follow one another.
pub(crate) fn minimum_degree(graph: &Graph, weights: &[usize]) -> Vec<u32> {
    minimum_degree_of(graph, weights, graph.size())
}

/// The same of the first `count` vertices only: those after them are eliminated later, and count in the degrees until then.
pub(super) fn minimum_degree_of(graph: &Graph, weights: &[usize], count: usize) -> Vec<u32> {
    let mut quotient = Quotient::new(graph, weights, count);
    quotient.eliminate(count)
}

impl Quotient {
    fn new(graph: &Graph, weights: &[usize], count: usize) -> Self {
        let n = graph.size();
        let sum = |i: usize| graph.of(i).iter().map(|j| weights[*j as usize]).sum();
        Self {
            weight: weights.to_vec(),
            stands_for: (0..n as u32).map(|i| vec![i]).collect(),
            variables: (0..n).map(|i| graph.of(i).to_vec()).collect(),
            elements: vec![Vec::new(); n],
            members: vec![Vec::new(); n],
            size: vec![0; n],
            degree: (0..n).map(sum).collect(),
            most: weights.iter().sum(),
            kept: (0..n).map(|i| i >= count).collect(),
            mark: vec![0; n],
            stamp: 0,
            outside: vec![0; n],
            seen: vec![0; n],
        }
    }

    fn eliminate(&mut self, count: usize) -> Vec<u32> {
        let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); self.most + 1];
        for (i, degree) in self.degree.iter().enumerate().take(count) {
            buckets[*degree].push(i as u32);
        }
        let mut order = Vec::with_capacity(count);
        let mut least = 0;
        while order.len() < count {
            let Some(i) = buckets[least].pop() else {
                least += 1;
                continue;
            };
            let i = i as usize;
            // A variable lies in every bucket that it has passed: only the last one counts.
            if self.weight[i] == 0 || self.degree[i] != least {
                continue;
            }
            order.append(&mut self.stands_for[i]);
            for j in self.pivot(i) {
                if self.kept[j as usize] {
                    continue;
                }
                let degree = self.degree[j as usize];
                buckets[degree].push(j);
                // Degrees fall too: the search for the least goes back.
                least = least.min(degree);
            }
        }
        order
    }

    /// Eliminates `p`: it becomes an element. Returns its variables, whose degrees are new.
    fn pivot(&mut self, p: usize) -> Vec<u32> {
        self.weight[p] = 0;
        let mut members = self.gather(p);
        self.count_outside(&members);
        let total: usize = members.iter().map(|i| self.weight[*i as usize]).sum();
        for &i in &members {
            self.update(i as usize, p, total);
        }
        self.join_alike(&members);
        members.retain(|i| self.weight[*i as usize] > 0);
        self.size[p] = total;
        self.members[p].clone_from(&members);
        members
    }

    /// The variables that elimination of `p` joins; its elements are absorbed.
    fn gather(&mut self, p: usize) -> Vec<u32> {
        self.stamp += 1;
        let mut members = Vec::new();
        let mut take = |list: &[u32], mark: &mut [u32], weight: &[usize], stamp: u32| {
            for &j in list {
                if weight[j as usize] > 0 && mark[j as usize] != stamp {
                    mark[j as usize] = stamp;
                    members.push(j);
                }
            }
        };
        let own = std::mem::take(&mut self.variables[p]);
        take(&own, &mut self.mark, &self.weight, self.stamp);
        for e in std::mem::take(&mut self.elements[p]) {
            // All that an absorbed element joins the new one joins too: its list is given up.
            let list = std::mem::take(&mut self.members[e as usize]);
            take(&list, &mut self.mark, &self.weight, self.stamp);
        }
        members
    }

    /// For every element next to the new one: the weight of its variables that the new one lacks.
    fn count_outside(&mut self, members: &[u32]) {
        for &i in members {
            let weight = self.weight[i as usize];
            for &e in &self.elements[i as usize] {
                let e = e as usize;
                if self.seen[e] != self.stamp {
                    self.seen[e] = self.stamp;
                    // The whole element at first sight; each member met then takes its weight off.
                    self.outside[e] = self.size[e];
                }
                self.outside[e] = self.outside[e].saturating_sub(weight);
            }
        }
    }

    /// New lists and an upper bound of the degree of variable `i` of the new element `p` of weight `total`.
    fn update(&mut self, i: usize, p: usize, total: usize) {
        let (mark, weight, stamp) = (&self.mark, &self.weight, self.stamp);
        self.variables[i].retain(|j| weight[*j as usize] > 0 && mark[*j as usize] != stamp);
        let (members, outside) = (&self.members, &self.outside);
        // An element inside the new one says nothing more.
        self.elements[i].retain(|e| !members[*e as usize].is_empty() && outside[*e as usize] > 0);
        let near: usize = self.variables[i].iter().map(|j| weight[*j as usize]).sum();
        let far: usize = self.elements[i].iter().map(|e| outside[*e as usize]).sum();
        self.elements[i].push(p as u32);
        // The approximate degree of Amestoy, Davis and Duff: what the lists add up to, but no more than the old degree
        // and all of the new element.
        let bound = (near + far + total - weight[i]).min(self.degree[i] + total);
        // Elements overlap: their sum may exceed all there is.
        self.degree[i] = bound.min(self.most);
    }

    /// Joins the variables of the new element that have the same neighbours now: they are eliminated together.
    fn join_alike(&mut self, members: &[u32]) {
        let key = |i: u32| {
            let lists = [&self.variables[i as usize], &self.elements[i as usize]];
            let sums = lists.map(|list| list.iter().map(|j| u64::from(*j)).sum::<u64>());
            (sums[0], sums[1], lists[0].len(), lists[1].len(), self.kept[i as usize])
        };
        let mut keyed: Vec<_> = members.iter().map(|i| (key(*i), *i)).collect();
        // Equal keys become neighbours, and the order does not depend on that of the lists.
        keyed.sort_unstable();
        for at in 0..keyed.len() {
            let (key, i) = keyed[at];
            if self.weight[i as usize] == 0 {
                continue;
            }
            self.stamp += 1;
            let lists = self.variables[i as usize].iter().chain(&self.elements[i as usize]);
            lists.for_each(|j| self.mark[*j as usize] = self.stamp);
            for &(_, j) in keyed[at + 1..].iter().take_while(|(other, _)| *other == key) {
                let k = j as usize;
                // Variables and elements have numbers of their own: an element is no variable any more.
                let lists = self.variables[k].iter().chain(&self.elements[k]);
                let same = lists.into_iter().all(|v| self.mark[*v as usize] == self.stamp);
                if self.weight[k] > 0 && same {
                    self.join(k, i as usize);
                }
            }
        }
    }

    /// `k` goes with `i` from now on.
    fn join(&mut self, k: usize, i: usize) {
        // `k` is no neighbour of `i` any more, but a part of it. The bound may already be below: never under zero.
        self.degree[i] = self.degree[i].saturating_sub(self.weight[k]);
        self.weight[i] += std::mem::take(&mut self.weight[k]);
        let vertices = std::mem::take(&mut self.stands_for[k]);
        self.stands_for[i].extend(vertices);
        self.variables[k] = Vec::new();
        self.elements[k] = Vec::new();
    }
}
