//! Elements of a lens: parts that are mounted as one body.

use petzval_lens::Prescription;

/// Returns the first and the last row of each element: lenses with all that is cemented to them,
/// and mirrors.
pub(super) fn elements(lens: &Prescription) -> Vec<[usize; 2]> {
    let mut elements = Vec::new();
    let mut first = None;
    for (i, row) in lens.rows.iter().enumerate() {
        let glass = row.index != 1.0;
        match (first, glass) {
            (None, true) => first = Some(i),
            (None, false) if row.mirror => elements.push([i, i]),
            (Some(start), false) => {
                elements.push([start, i]);
                first = None;
            }
            _ => {}
        }
    }
    // A lens whose film is not in air ends inside its last element.
    elements.extend(first.map(|start| [start, lens.rows.len() - 1]));
    elements
}

/// Returns the rows behind which a medium other than air begins, each with the last row behind
/// which it goes on: beyond a stop inside it, or a mirror at its back.
pub(super) fn media(lens: &Prescription) -> Vec<[usize; 2]> {
    let mut media: Vec<[usize; 2]> = Vec::new();
    for (i, row) in lens.rows.iter().enumerate() {
        if row.index == 1.0 {
            continue;
        }
        let inside = i > 0 && {
            let before = &lens.rows[i - 1];
            let same = before.index == row.index && before.glass == row.glass;
            same && (row.mirror || row.stop && row.is_plane())
        };
        match media.last_mut() {
            Some([_, last]) if inside && *last + 1 == i => *last = i,
            _ => media.push([i, i]),
        }
    }
    media
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_lens::Row;

    fn lens(rows: &[(f64, bool, bool)]) -> Prescription {
        let row = |&(index, stop, mirror): &(f64, bool, bool)| Row {
            index,
            stop,
            mirror,
            diameter: 10.0,
            ..Row::default()
        };
        Prescription::new("rows", rows.iter().map(row).collect()).expect("one stop")
    }

    #[test]
    fn cemented_surfaces_are_one_element_and_a_stop_in_air_is_none() {
        let doublet = [(1.5, false, false), (1.6, false, false), (1.0, false, false)];
        let single = [(1.0, true, false), (1.7, false, false), (1.0, false, false)];
        let lens = lens(&[doublet, single].concat());
        assert_eq!(elements(&lens), [[0, 2], [4, 5]]);
        assert_eq!(media(&lens), [[0, 0], [1, 1], [4, 4]]);
    }

    #[test]
    fn a_mirror_is_an_element_and_the_glass_before_a_back_mirror_is_one_medium() {
        let mangin = [(1.5, false, false), (1.5, false, true), (1.0, false, false)];
        let lens = lens(&[&[(1.0, true, true)][..], &mangin].concat());
        assert_eq!(elements(&lens), [[0, 0], [1, 3]]);
        assert_eq!(media(&lens), [[1, 2]]);
    }
}
