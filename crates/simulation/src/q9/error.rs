//! Why a mesh cannot be used.

/// What is wrong with a mesh. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// No element at all.
    #[error("the mesh has no element")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("node {node} lies at ({x}, {y}): not finite")]
    NotFinite {
        /// The node.
        node: usize,
        /// Its abscissa.
        x: f64,
        /// Its ordinate.
        y: f64,
    },
    /// An element names a node that does not exist.
    #[error("element {element} names node {node}; there are {nodes} nodes")]
    MissingNode {
        /// The element.
        element: usize,
        /// The node it names.
        node: usize,
        /// How many there are.
        nodes: usize,
    },
    /// An element names a node twice.
    #[error("element {element} names node {node} twice")]
    RepeatedNode {
        /// The element.
        element: usize,
        /// The node.
        node: usize,
    },
    /// A node belongs to no element: nothing would hold it.
    #[error("node {node} belongs to no element")]
    UnusedNode {
        /// The node.
        node: usize,
    },
    /// The nodes of an element run clockwise: its map turns the plane over everywhere.
    #[error("element {element} runs clockwise (its area is {area:e}): number its nodes counter-clockwise")]
    Clockwise {
        /// The element.
        element: usize,
        /// Its area, negative.
        area: f64,
    },
    /// The map of an element folds or is singular, as where a middle node lies at the quarter of its side or beyond.
    #[error(
        "element {element} folds at (u, v) = ({u:.3}, {v:.3}): the determinant of its map is {determinant:e} there, its \
         mean {mean:e}; move the middle nodes of its sides towards their middles"
    )]
    Folded {
        /// The element.
        element: usize,
        /// Where, local coordinate.
        u: f64,
        /// Where, local coordinate.
        v: f64,
        /// The determinant of the map there.
        determinant: f64,
        /// Its mean over the element.
        mean: f64,
    },
    /// A side is shared by more than two elements, or by two that lie on the same side of it.
    #[error("the side of nodes {side:?} belongs to {count} elements that do not lie on its two sides")]
    Side {
        /// The nodes of the side.
        side: [usize; 3],
        /// How many elements name it.
        count: usize,
    },
    /// A size or a count of a generated mesh.
    #[error("{what} is {found}; it must be {allowed}")]
    Shape {
        /// Which number.
        what: &'static str,
        /// The number found.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}
