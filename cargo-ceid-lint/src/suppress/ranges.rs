//! Pieces of code in an order in which those around a place are found without a look at all of them.

use std::collections::BTreeSet;
use std::ops::Range;

use rustc_hash::FxHashMap;

use super::Placed;
use crate::source::{FileId, Span};

/// Pieces of code with the numbers of what stands for them.
#[derive(Clone, Debug, Default)]
pub(super) struct Ranges(FxHashMap<FileId, Vec<Piece>>);

/// A piece in a list that is sorted by its beginnings, and read as a tree: the middle of each part of the list is above the
/// rest of that part.
#[derive(Clone, Debug)]
struct Piece {
    span: Span,
    number: usize,
    /// The furthest end in the part of the list of which it is the middle.
    furthest: u32,
}

impl Ranges {
    /// The pieces that a list stands for, with the numbers in that list.
    pub(super) fn of<T>(list: &[Placed<T>]) -> Self {
        let mut files: FxHashMap<FileId, Vec<Piece>> = FxHashMap::default();
        for (number, placed) in list.iter().enumerate() {
            for Span { file, start, end } in placed.reach.iter().map(|reach| reach.span) {
                let piece = Piece { span: Span { file, start, end }, number, furthest: end };
                files.entry(file).or_default().push(piece);
            }
        }
        #[expect(clippy::iter_over_hash_type, reason = "each file is put in order by itself")]
        for pieces in files.values_mut() {
            pieces.sort_by_key(|piece| piece.span.start);
            set_furthest(pieces);
        }
        Self(files)
    }

    /// The numbers of those in which one of these places begins.
    pub(super) fn around<'a>(&self, places: impl Iterator<Item = &'a Span>) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for place in places {
            if let Some(pieces) = self.0.get(&place.file) {
                visit(pieces, place.start, &mut found);
            }
        }
        found
    }
}

/// The middle of a list, with what lies before and behind it.
fn halves(length: usize) -> (Range<usize>, usize, Range<usize>) {
    let middle = length / 2;
    (0..middle, middle, middle + 1..length)
}

fn set_furthest(pieces: &mut [Piece]) -> u32 {
    if pieces.is_empty() {
        return 0;
    }
    let (before, middle, behind) = halves(pieces.len());
    let furthest = set_furthest(&mut pieces[before]).max(set_furthest(&mut pieces[behind]));
    pieces[middle].furthest = furthest.max(pieces[middle].span.end);
    pieces[middle].furthest
}

fn visit(pieces: &[Piece], at: u32, found: &mut BTreeSet<usize>) {
    let (before, middle, behind) = halves(pieces.len());
    let Some(piece) = pieces.get(middle).filter(|piece| at < piece.furthest) else { return };
    visit(&pieces[before], at, found);
    if piece.span.start <= at {
        found.extend((at < piece.span.end).then_some(piece.number));
        visit(&pieces[behind], at, found);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Reach;
    use super::*;

    #[test]
    fn every_place_is_in_the_pieces_around_it() {
        let file = FileId(0);
        // Pieces that lie in, beside and across each other, in no order.
        let spans: Vec<Span> = (0..40u32).map(|n| Span::new(file, n * 7 % 31, n * 7 % 31 + 1 + n * 5 % 13)).collect();
        let placed = |span: &Span| Placed {
            said: (),
            span: *span,
            removal: *span,
            package: 0,
            target: 0,
            reach: vec![Reach { span: *span, is_plain: true }],
            is_placed: true,
        };
        let ranges = Ranges::of(&spans.iter().map(placed).collect::<Vec<_>>());
        for at in 0..50 {
            let place = Span::new(file, at, at + 1);
            let all = spans.iter().enumerate().filter(|(_, span)| (span.start..span.end).contains(&at));
            let expected: BTreeSet<usize> = all.map(|(number, _)| number).collect();
            assert_eq!(ranges.around([place].iter()), expected, "{at}");
        }
        assert!(ranges.around([Span::new(FileId(1), 3, 4)].iter()).is_empty());
    }
}
