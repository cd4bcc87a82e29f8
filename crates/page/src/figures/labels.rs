//! Finds room for small texts beside the points that they name.

/// A rectangle that is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taken {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Taken {
    pub(super) fn around((x, y): (f64, f64), width: f64, height: f64) -> Self {
        Self { left: x - 0.5 * width, top: y - 0.5 * height, right: x + 0.5 * width, bottom: y + 0.5 * height }
    }

    fn overlap(&self, other: &Self) -> f64 {
        let width = self.right.min(other.right) - self.left.max(other.left);
        let height = self.bottom.min(other.bottom) - self.top.max(other.top);
        width.max(0.0) * height.max(0.0)
    }

    fn area(&self) -> f64 {
        (self.right - self.left) * (self.bottom - self.top)
    }
}

/// The places taken so far, inside an outer rectangle.
#[derive(Clone, Debug)]
pub(super) struct Room {
    pub(super) outer: Taken,
    pub(super) taken: Vec<Taken>,
}

impl Room {
    /// The center for a text of this size near a point, the nearest that is free or else the least covered; it is taken then.
    pub(super) fn place_near(&mut self, point: (f64, f64), width: f64, height: f64) -> (f64, f64) {
        let mut best: Option<((f64, f64), f64)> = None;
        for distance in [4.0, 12.0, 22.0, 34.0] {
            // Above and to the right first, where a reader looks.
            for (dx, dy) in
                [(1.0, -1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, -1.0), (0.0, 1.0)]
            {
                let at = (point.0 + dx * (0.5 * width + distance), point.1 + dy * (0.5 * height + distance));
                let covered = self.covered(&Taken::around(at, width, height));
                if best.is_none_or(|(_, least)| covered < least) {
                    best = Some((at, covered));
                }
            }
        }
        let at = best.map_or(point, |(at, _)| at);
        self.taken.push(Taken::around(at, width, height));
        at
    }

    /// Takes a place if it is free.
    pub(super) fn take_if_free(&mut self, place: Taken) -> bool {
        let free = self.covered(&place) <= 0.0;
        if free {
            self.taken.push(place);
        }
        free
    }

    /// How much of a place is taken or outside.
    fn covered(&self, place: &Taken) -> f64 {
        let inside: f64 = self.taken.iter().map(|taken| taken.overlap(place)).sum();
        inside + place.area() - self.outer.overlap(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room() -> Room {
        Room { outer: Taken { left: 0.0, top: 0.0, right: 200.0, bottom: 100.0 }, taken: Vec::new() }
    }

    #[test]
    fn labels_of_one_point_do_not_overlap() {
        let mut room = room();
        for _ in 0..6 {
            room.place_near((100.0, 50.0), 20.0, 14.0);
        }
        for (i, a) in room.taken.iter().enumerate() {
            for b in &room.taken[..i] {
                assert!(a.overlap(b) <= 0.0, "{a:?} and {b:?}");
            }
        }
    }

    #[test]
    fn labels_stay_inside() {
        let mut room = room();
        let (x, y) = room.place_near((199.0, 1.0), 20.0, 14.0);
        assert!(x < 190.0 && y > 7.0, "{x} {y}");
    }

    #[test]
    fn taken_place_is_not_free() {
        let mut room = room();
        let place = Taken::around((50.0, 50.0), 10.0, 10.0);
        assert!(room.take_if_free(place), "empty room");
        assert!(!room.take_if_free(Taken::around((55.0, 50.0), 10.0, 10.0)), "overlap");
        assert!(!room.take_if_free(Taken::around((0.0, 0.0), 10.0, 10.0)), "outside");
    }
}
