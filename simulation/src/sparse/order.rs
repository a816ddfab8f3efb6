//! An order of elimination that fills little: minimum degree on the quotient graph.

/// A variable's place in the quotient graph (Amestoy, Davis and Duff 1996, without their hashing of equal variables).
struct Quotient {
    /// Unknowns that a variable stands for; 0 once it is eliminated.
    weight: Vec<usize>,
    variables: Vec<Vec<u32>>,
    elements: Vec<Vec<u32>>,
    /// The variables of the element that an eliminated variable became; empty once absorbed.
    members: Vec<Vec<u32>>,
    degree: Vec<usize>,
    mark: Vec<u32>,
    stamp: u32,
    /// `|L_e \ L_p|` of the elements met at this step.
    outside: Vec<usize>,
    seen: Vec<u32>,
}

/// An order of elimination of the symmetric pattern `neighbours` (without the diagonal): the k-th unknown eliminated.
///
/// Unknowns with the same neighbours, as the two coordinates of a node, stay together.
pub fn minimum_degree(neighbours: &[Vec<u32>]) -> Vec<usize> {
    let (group_of, groups) = alike(neighbours);
    let mut quotient = Quotient::new(neighbours, &group_of, &groups);
    let mut order = Vec::with_capacity(neighbours.len());
    for pivot in quotient.eliminate() {
        order.extend(groups[pivot].iter().map(|i| *i as usize));
    }
    order
}

/// Groups of unknowns whose closed neighbourhoods are equal.
fn alike(neighbours: &[Vec<u32>]) -> (Vec<u32>, Vec<Vec<u32>>) {
    let closed = |i: usize| {
        let mut list = neighbours[i].clone();
        list.push(i as u32);
        list.sort_unstable();
        list.dedup();
        list
    };
    let mut known: std::collections::HashMap<Vec<u32>, u32> = std::collections::HashMap::new();
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut group_of = Vec::with_capacity(neighbours.len());
    for i in 0..neighbours.len() {
        let next = groups.len() as u32;
        let group = *known.entry(closed(i)).or_insert(next);
        if group == next {
            groups.push(Vec::new());
        }
        groups[group as usize].push(i as u32);
        group_of.push(group);
    }
    (group_of, groups)
}

impl Quotient {
    fn new(neighbours: &[Vec<u32>], group_of: &[u32], groups: &[Vec<u32>]) -> Self {
        let n = groups.len();
        let variables: Vec<Vec<u32>> = groups
            .iter()
            .enumerate()
            .map(|(g, members)| {
                let first = members[0] as usize;
                let mut list: Vec<u32> = neighbours[first].iter().map(|j| group_of[*j as usize]).collect();
                list.sort_unstable();
                list.dedup();
                list.retain(|j| *j as usize != g);
                list
            })
            .collect();
        let weight: Vec<usize> = groups.iter().map(Vec::len).collect();
        let sum = |list: &Vec<u32>| list.iter().map(|j| weight[*j as usize]).sum();
        let degree = variables.iter().map(sum).collect();
        Self {
            variables,
            degree,
            weight,
            elements: vec![Vec::new(); n],
            members: vec![Vec::new(); n],
            mark: vec![0; n],
            stamp: 0,
            outside: vec![0; n],
            seen: vec![0; n],
        }
    }

    /// The groups in the order of their elimination.
    fn eliminate(&mut self) -> Vec<usize> {
        let n = self.weight.len();
        let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); self.weight.iter().sum::<usize>() + 1];
        for (i, degree) in self.degree.iter().enumerate() {
            buckets[*degree].push(i as u32);
        }
        let mut order = Vec::with_capacity(n);
        let mut least = 0;
        while order.len() < n {
            let Some(i) = buckets[least].pop() else {
                least += 1;
                continue;
            };
            let i = i as usize;
            // A variable lies in every bucket that it has passed: only the last one counts.
            if self.weight[i] == 0 || self.degree[i] != least {
                continue;
            }
            order.push(i);
            for j in self.pivot(i) {
                let degree = self.degree[j as usize];
                buckets[degree].push(j);
                least = least.min(degree);
            }
        }
        order
    }

    /// Eliminates `p`: it becomes an element. Returns its variables, whose degrees are new.
    fn pivot(&mut self, p: usize) -> Vec<u32> {
        self.weight[p] = 0;
        let members = self.gather(p);
        self.count_outside(&members);
        let total: usize = members.iter().map(|i| self.weight[*i as usize]).sum();
        for &i in &members {
            self.update(i as usize, p, total);
        }
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
                    let size = self.members[e].iter().map(|j| self.weight[*j as usize]).sum();
                    self.outside[e] = size;
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
        self.degree[i] = (near + far + total - weight[i]).min(self.degree[i] + total);
    }
}
