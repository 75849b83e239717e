//! The faces around vertices of a mesh under repair.

/// A triangle and what it lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Face {
    pub triangle: u32,
    pub surface: u32,
    pub reversed: bool,
}

/// The faces around the vertices in question.
#[derive(Default)]
pub(super) struct Stars {
    /// Per vertex its star's place in the list, counted from 1; 0 for none.
    place: Vec<u32>,
    stars: Vec<Star>,
    /// The vertices, in the list's order.
    pub vertices: Vec<u32>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Star {
    pub(super) faces: Vec<Face>,
    /// The last merger that changed it, or a corner of its faces.
    pub(super) changed: u32,
}

impl Stars {
    /// No star yet, for so many vertices.
    pub(super) fn none_of(vertices: usize) -> Self {
        Self {
            place: vec![0; vertices],
            ..Self::default()
        }
    }

    /// Whether a vertex has a star.
    pub(super) fn has(&self, vertex: u32) -> bool {
        self.place[vertex as usize] != 0
    }

    pub(super) fn get(&self, vertex: u32) -> Option<&Star> {
        let place = self.place[vertex as usize] as usize;
        self.stars.get(place.wrapping_sub(1))
    }

    pub(super) fn get_mut(&mut self, vertex: u32) -> Option<&mut Star> {
        let place = self.place[vertex as usize] as usize;
        self.stars.get_mut(place.wrapping_sub(1))
    }

    /// Sees to it that a vertex has a star.
    pub(super) fn want(&mut self, vertex: u32) {
        let place = &mut self.place[vertex as usize];
        if *place == 0 {
            self.stars.push(Star::default());
            self.vertices.push(vertex);
            *place = self.stars.len() as u32;
        }
    }
}
