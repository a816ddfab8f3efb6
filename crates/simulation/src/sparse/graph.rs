//! The pattern of a symmetric matrix as a graph, and unknowns that are alike.

/// Neighbours of every vertex, without itself, each once.
#[derive(Debug, Clone, Default)]
pub(super) struct Graph {
    start: Vec<usize>,
    list: Vec<u32>,
}

impl Graph {
    /// The graph of a pattern: places of one triangle in any order, as often as they like.
    pub(super) fn of_places(size: usize, places: &[(u32, u32)]) -> Self {
        let mut start = vec![0_usize; size + 1];
        for &(i, j) in places.iter().filter(|(i, j)| i != j) {
            start[i as usize + 1] += 1;
            start[j as usize + 1] += 1;
        }
        for k in 0..size {
            start[k + 1] += start[k];
        }
        let (mut next, mut list) = (start.clone(), vec![0_u32; start[size]]);
        for &(i, j) in places.iter().filter(|(i, j)| i != j) {
            for (a, b) in [(i, j), (j, i)] {
                list[next[a as usize]] = b;
                next[a as usize] += 1;
            }
        }
        let whole = Self { start, list };
        Self::collect(size, |i, seen| {
            for &j in whole.of(i) {
                seen(j);
            }
        })
    }

    /// The graph whose vertex `i` has every neighbour that `visit` calls with, each once and without `i`.
    fn collect(size: usize, visit: impl Fn(usize, &mut dyn FnMut(u32))) -> Self {
        let mut graph = Self {
            start: vec![0],
            list: Vec::new(),
        };
        let mut mark = vec![u32::MAX; size];
        for i in 0..size {
            mark[i] = i as u32;
            visit(i, &mut |j| {
                if mark[j as usize] != i as u32 {
                    mark[j as usize] = i as u32;
                    graph.list.push(j);
                }
            });
            graph.start.push(graph.list.len());
        }
        graph
    }

    /// The graph of some vertices and of what lies next to them: these first, in their order, then the others, which see none of
    /// their own kind. With the vertex behind each number. `number` is `u32::MAX` for all vertices, before and after.
    pub(super) fn around(&self, inner: &[u32], number: &mut [u32]) -> (Self, Vec<u32>) {
        let mut vertices = inner.to_vec();
        for (k, i) in inner.iter().enumerate() {
            number[*i as usize] = k as u32;
        }
        for &j in inner.iter().flat_map(|i| self.of(*i as usize)) {
            if number[j as usize] == u32::MAX {
                number[j as usize] = vertices.len() as u32;
                vertices.push(j);
            }
        }
        let graph = Self::collect(vertices.len(), |k, seen| {
            let inside = k < inner.len();
            let near = self.of(vertices[k] as usize).iter().map(|j| number[*j as usize]);
            near.filter(|j| *j != u32::MAX && (inside || (*j as usize) < inner.len()))
                .for_each(seen);
        });
        vertices.iter().for_each(|i| number[*i as usize] = u32::MAX);
        (graph, vertices)
    }

    /// Vertices.
    pub(super) fn size(&self) -> usize {
        self.start.len() - 1
    }

    /// The neighbours of a vertex.
    pub(super) fn of(&self, vertex: usize) -> &[u32] {
        &self.list[self.start[vertex]..self.start[vertex + 1]]
    }

    /// Groups of vertices whose neighbours and themselves are the same set, as the two coordinates of a node: the graph of
    /// the groups, and the vertices of each. Those that are to be `alone` are groups of their own.
    pub(super) fn alike(&self, alone: &[bool]) -> (Self, Vec<Vec<u32>>) {
        let n = self.size();
        // Sums of scrambled numbers: equal for equal sets, whatever their order.
        let scrambled = |i: u32| (u64::from(i) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
        let sum = |i: usize| {
            self.of(i)
                .iter()
                .fold(scrambled(i as u32), |s, j| s.wrapping_add(scrambled(*j)))
        };
        let sums: Vec<u64> = (0..n).map(sum).collect();
        let (mut group_of, mut groups) = (vec![u32::MAX; n], Vec::new());
        let mut mark = vec![u32::MAX; n];
        for i in 0..n {
            if group_of[i] != u32::MAX {
                continue;
            }
            let group = groups.len() as u32;
            group_of[i] = group;
            let mut members = vec![i as u32];
            self.of(i).iter().for_each(|j| mark[*j as usize] = i as u32);
            mark[i] = i as u32;
            // Vertices that are alike are neighbours: each is in the other's set.
            for &j in self.of(i) {
                let k = j as usize;
                // Sums only pick candidates: two sets may have the same one.
                let like = sums[k] == sums[i]
                    && group_of[k] == u32::MAX
                    && self.of(k).len() == self.of(i).len()
                    && !(alone[i] || alone[k]);
                if like && self.of(k).iter().all(|v| mark[*v as usize] == i as u32) {
                    group_of[k] = group;
                    members.push(j);
                }
            }
            groups.push(members);
        }
        // The first vertex of a group speaks for all of it.
        let between = Self::collect(groups.len(), |g, seen| {
            for &j in self.of(groups[g][0] as usize) {
                seen(group_of[j as usize]);
            }
        });
        (between, groups)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_with_the_same_neighbours_are_found() {
        // Three nodes in a row, two unknowns each, and one unknown that sees one coordinate only.
        let mut places = vec![(6, 4)];
        for i in 0..6_u32 {
            for j in 0..=i {
                if i / 2 - j / 2 <= 1 {
                    places.push((i, j));
                    places.push((i, j));
                }
            }
        }
        let graph = Graph::of_places(7, &places);
        assert_eq!(graph.of(0).len(), 3);
        let (between, mut groups) = graph.alike(&[false; 7]);
        groups.iter_mut().for_each(|g| g.sort_unstable());
        assert_eq!(groups, [vec![0, 1], vec![2, 3], vec![4], vec![5], vec![6]]);
        assert_eq!((between.of(0), between.of(4)), (&[1_u32][..], &[2_u32][..]));
        assert_eq!(between.of(1).len(), 3);
    }
}
