//! Packets whose lanes are anywhere in a column.

use super::Real;

/// Entries of columns, one for each lane of a packet.
#[derive(Clone, Copy, Debug)]
pub struct LaneIndices<'a> {
    /// Entries; as many as there are lanes, or fewer.
    indices: &'a [u32],
    /// The first entry, if the lanes are a whole packet of successive ones.
    first: Option<usize>,
}

impl<'a> LaneIndices<'a> {
    /// The lanes of these entries.
    #[inline(always)]
    pub fn new<R: Real>(indices: &'a [u32]) -> Self {
        let first = indices[0];
        let successive = indices.len() == R::LANES
            && indices.iter().zip(first..).all(|(&index, expected)| index == expected);
        Self { indices, first: successive.then_some(first as usize) }
    }

    /// Returns the entries.
    pub fn indices(&self) -> &'a [u32] {
        self.indices
    }

    /// Returns the lanes of the packet that have an entry, as bits.
    pub fn lanes(&self) -> u32 {
        (1 << self.indices.len()) - 1
    }

    /// Loads the entries of a column; lanes without an entry are 0.
    #[inline(always)]
    pub fn load<R: Real<Scalar = f32>>(&self, column: &[f32]) -> R {
        if let Some(first) = self.first {
            return R::load(&column[first..]);
        }
        let mut lanes = [0.0; 8];
        for (lane, &index) in lanes.iter_mut().zip(self.indices) {
            *lane = column[index as usize];
        }
        R::load(&lanes)
    }

    /// Stores a packet in the entries of a column.
    #[inline(always)]
    pub fn store<R: Real<Scalar = f32>>(&self, from: R, column: &mut [f32]) {
        if let Some(first) = self.first {
            return from.store(&mut column[first..]);
        }
        let mut lanes = [0.0; 8];
        from.store(&mut lanes);
        for (lane, &index) in lanes.iter().zip(self.indices) {
            column[index as usize] = *lane;
        }
    }

    /// Loads the entries of three columns.
    #[inline(always)]
    pub fn load_vector<R: Real<Scalar = f32>, C: AsRef<[f32]>>(&self, columns: &[C; 3]) -> [R; 3] {
        [
            self.load(columns[0].as_ref()),
            self.load(columns[1].as_ref()),
            self.load(columns[2].as_ref()),
        ]
    }

    /// Stores a packet of vectors in the entries of three columns.
    #[inline(always)]
    pub fn store_vector<R: Real<Scalar = f32>, C: AsMut<[f32]>>(
        &self,
        from: [R; 3],
        columns: &mut [C; 3],
    ) {
        for axis in 0..3 {
            self.store(from[axis], columns[axis].as_mut());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::f32x8;

    #[test]
    fn scattered_and_successive_entries_are_loaded_and_stored() {
        let column: Vec<f32> = (0..40).map(|i| i as f32).collect();
        for indices in [vec![3, 4, 5, 6, 7, 8, 9, 10], vec![9, 1, 30], vec![7, 6, 5, 4, 3, 2, 1, 0]]
        {
            let lanes = LaneIndices::new::<f32x8>(&indices);
            let loaded: f32x8 = lanes.load(&column);
            let mut copy = vec![-1.0; 40];
            lanes.store(loaded, &mut copy);
            for i in 0..40 {
                let expected = if indices.contains(&(i as u32)) { column[i] } else { -1.0 };
                assert_eq!(copy[i], expected, "{indices:?}, {i}");
            }
            assert_eq!(lanes.lanes().count_ones() as usize, indices.len());
        }
    }
}
