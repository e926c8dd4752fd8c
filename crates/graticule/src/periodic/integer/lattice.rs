//! The whole solutions of homogeneous equations with whole coefficients.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use super::form::Form;

/// Finds free whole parameters of all whole solutions: the result has for each unknown its sum of
/// parameters, and the number of parameters. Every choice of parameters gives a solution, and every
/// solution comes from one choice.
///
/// One equation after the other is solved for a parameter with the coefficient ±1, once divided by
/// what its coefficients have in common. Where there is none, Euclid's steps on the parameters make
/// one. `rank` tells which parameters to solve for first: those of least rank.
///
/// The shortest equation comes first, and of its parameters the one that the fewest sums use, as in
/// H. M. Markowitz, *The Elimination Form of the Inverse*, 1957: on a surface with many handles and
/// lines the sums would fill up otherwise.
///
/// Cost: linear in the entries touched; equations of the cut have a handful each.
pub(super) fn solve_whole(
    unknowns: usize,
    equations: &[Form],
    rank: impl Fn(u32) -> u32,
) -> (Vec<Form>, usize) {
    let mut lattice = Lattice {
        rows: (0..unknowns as u32).map(Form::unknown).collect(),
        users: (0..unknowns as u32)
            .map(|row| BTreeSet::from([row]))
            .collect(),
    };
    let mut is_left = vec![true; unknowns];
    let lengths = equations.iter().map(|equation| equation.terms().len());
    let mut waiting: BinaryHeap<_> = lengths.zip(0..).map(Reverse).collect();
    while let Some(Reverse((length, number))) = waiting.pop() {
        let mut residual = lattice.substituted(&equations[number]);
        // Those solved since may have made it longer.
        if residual.terms().len() > length {
            waiting.push(Reverse((residual.terms().len(), number)));
            continue;
        }
        while let Some(pivot) = lattice.best_pivot(&residual, &rank) {
            if lattice.reduce(&mut residual, pivot) {
                lattice.eliminate(pivot);
                is_left[pivot as usize] = false;
                break;
            }
        }
    }
    let mut numbers = vec![u32::MAX; unknowns];
    let mut count = 0;
    for (number, _) in numbers.iter_mut().zip(&is_left).filter(|(_, left)| **left) {
        *number = count;
        count += 1;
    }
    let renumbered = lattice.rows.iter().map(|row| {
        let mut fresh = Form::default();
        for &(column, value) in row.terms() {
            fresh.add(value, &Form::unknown(numbers[column as usize]));
        }
        fresh
    });
    (renumbered.collect(), count as usize)
}

struct Lattice {
    /// Each unknown as a sum of parameters.
    rows: Vec<Form>,
    /// The unknowns that use each parameter.
    users: Vec<BTreeSet<u32>>,
}

impl Lattice {
    fn substituted(&self, equation: &Form) -> Form {
        let mut sum = Form::default();
        for &(unknown, factor) in equation.terms() {
            sum.add(factor, &self.rows[unknown as usize]);
        }
        sum
    }

    /// Changes the parameters so that the others have smaller coefficients than the pivot in the
    /// equation; tells whether only the pivot is left.
    fn reduce(&mut self, equation: &mut Form, pivot: u32) -> bool {
        let own = equation.coefficient(pivot);
        for (column, value) in equation.terms().to_vec() {
            let times = value.div_euclid(own);
            if column != pivot && times != 0 {
                // pivot = new pivot - times * column: the equation loses times * own at column.
                self.shift(pivot, column, -times);
                equation.add(-times * own, &Form::unknown(column));
            }
        }
        equation.terms().len() == 1
    }

    /// Replaces a parameter by itself plus a multiple of another one.
    fn shift(&mut self, parameter: u32, other: u32, times: i64) {
        let users: Vec<u32> = self.users[parameter as usize].iter().copied().collect();
        for user in users {
            let row = &mut self.rows[user as usize];
            let factor = row.coefficient(parameter) * times;
            row.add(factor, &Form::unknown(other));
            if row.coefficient(other) == 0 {
                self.users[other as usize].remove(&user);
            } else {
                self.users[other as usize].insert(user);
            }
        }
    }

    /// The parameter of smallest coefficient, of these the one of least rank, of these the one of
    /// fewest uses.
    fn best_pivot(&self, equation: &Form, rank: impl Fn(u32) -> u32) -> Option<u32> {
        let terms = equation.terms().iter();
        let best = terms.min_by_key(|&&(column, value)| {
            let uses = self.users[column as usize].len();
            (value.abs(), rank(column), uses, column)
        });
        best.map(|term| term.0)
    }

    /// Sets a parameter to 0.
    fn eliminate(&mut self, parameter: u32) {
        for user in std::mem::take(&mut self.users[parameter as usize]) {
            let row = &mut self.rows[user as usize];
            let factor = row.coefficient(parameter);
            row.add(-factor, &Form::unknown(parameter));
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in super::super) fn form(terms: &[(u32, i64)]) -> Form {
        let mut sum = Form::default();
        for &(column, value) in terms {
            sum.add(value, &Form::unknown(column));
        }
        sum
    }

    /// Checks that every choice of parameters solves the equations, and that every small solution
    /// comes from whole parameters.
    fn check(unknowns: usize, equations: &[Form], dimension: usize) {
        let (rows, count) = solve_whole(unknowns, equations, |_| 0);
        assert_eq!(count, dimension);
        let value = |parameters: &[i64]| -> Vec<i64> {
            rows.iter().map(|row| row.value(parameters)).collect()
        };
        let solves = |values: &[i64]| equations.iter().all(|e| e.value(values) == 0);
        let cube = |n: usize, half: i64| {
            let side = 2 * half + 1;
            (0..side.pow(n as u32)).map(move |mut code| {
                let digit = |_| {
                    let digit = code % side - half;
                    code /= side;
                    digit
                };
                (0..n).map(digit).collect::<Vec<i64>>()
            })
        };
        let reached: BTreeSet<Vec<i64>> = cube(count, 6).map(|p| value(&p)).collect();
        assert!(reached.iter().all(|values| solves(values)));
        for values in cube(unknowns, 1).filter(|values| solves(values)) {
            assert!(reached.contains(&values), "{values:?}");
        }
    }

    #[test]
    fn parameters_reach_all_whole_solutions_and_nothing_else() {
        check(3, &[form(&[(0, 1), (1, -1), (2, 2)])], 2);
        check(3, &[form(&[(0, 2), (1, 4), (2, -6)])], 2);
        check(3, &[form(&[(0, 2), (1, 3)])], 2);
        check(
            4,
            &[form(&[(0, 2), (1, 3), (2, 5)]), form(&[(1, 2), (3, -3)])],
            2,
        );
        check(2, &[form(&[(0, 1), (1, 1)]), form(&[(0, 1), (1, -1)])], 0);
        check(2, &[form(&[(0, 3)]), form(&[(0, 5)])], 1);
    }
}
