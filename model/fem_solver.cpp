// SPDX-License-Identifier: Apache-2.0
#include "model/fem_solver.hpp"

#include <algorithm>
#include <iterator>

namespace lcrig {
namespace {

constexpr std::size_t kFewUnknowns = 80;  // a part with no more unknowns is not halved

void add_cell(const FrontMatrix& to, const std::vector<int>& places, const double* stiffness) {
  std::size_t k = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j, ++k) {
      if (places[i] < 0 || places[j] < 0) continue;
      const auto [column, row] = std::minmax(places[i], places[j]);
      // two nodes of one cell that share an equation count twice on its diagonal
      const bool twice = i != j && row == column;
      to.column(static_cast<std::size_t>(column))[row] += (twice ? 2 : 1) * stiffness[k];
    }
  }
}

void add_half(const FrontMatrix& to, const std::vector<std::size_t>& places, const double* rest) {
  const std::size_t n = places.size();
  for (std::size_t j = 0; j < n; ++j) {
    double* column = to.column(places[j]);
    const double* from = rest + j * FrontMatrix::padded(n);
    for (std::size_t i = j; i < n; ++i) column[places[i]] += from[i];
  }
}

}  // namespace

bool FrontalSolver::Part::contains(const Part& other) const {
  return left <= other.left && other.right <= right && bottom <= other.bottom && other.top <= top;
}

// Divides the grid into fronts.
class FrontalSolver::Analysis {
 public:
  Analysis(const CellEquations& cells, std::size_t columns, std::size_t equations)
      : order(equations), cells_(cells), columns_(columns) {
    const std::size_t count = cells.all.size() / cells.dofs;
    const std::size_t rows = count / columns;
    extents_.assign(equations, {columns, 0, rows, 0});
    for (std::size_t i = 0; i < cells.all.size(); ++i) {
      const std::size_t cell = i / cells.dofs;
      const std::size_t column = cell % columns, row = cell / columns;
      if (const int equation = cells.all[i]; equation >= 0) {
        Part& e = extents_[static_cast<std::size_t>(equation)];
        e = {std::min(e.left, column), std::max(e.right, column + 1), std::min(e.bottom, row),
             std::max(e.top, row + 1)};
      }
    }
    whole = divide({0, columns, 0, rows});
    finish(whole);
  }

  std::vector<std::size_t> order;  // of elimination, by equation
  Front whole;
  std::size_t factor = 0, scratch = 0;  // sizes

 private:
  // The unknowns of the fronts are equations until finish() renumbers them.
  Front divide(const Part& part) {
    Front front;
    const std::size_t width = part.right - part.left, height = part.top - part.bottom;
    if (width * height == 1 || width * height * cells_.dofs <= kFewUnknowns) {
      add_cells(part, front);
    } else {
      Part one = part, other = part;
      if (width > height) {
        one.right = other.left = part.left + width / 2;
      } else {
        one.top = other.bottom = part.bottom + height / 2;
      }
      for (const Part& half : {one, other}) {
        const Front& added = front.halves.emplace_back(divide(half));
        const auto rest = added.unknowns.begin() + static_cast<std::ptrdiff_t>(added.eliminated);
        front.unknowns.insert(front.unknowns.end(), rest, added.unknowns.end());
      }
    }
    eliminate_inside(part, front);
    return front;
  }

  void add_cells(const Part& part, Front& front) {
    for (std::size_t row = part.bottom; row < part.top; ++row) {
      for (std::size_t column = part.left; column < part.right; ++column) {
        const std::size_t index = row * columns_ + column;
        const int* first = &cells_.all[index * cells_.dofs];
        front.cells.push_back({index, {first, first + cells_.dofs}});
        for (const int equation : front.cells.back().places) {
          if (equation >= 0) front.unknowns.push_back(static_cast<std::size_t>(equation));
        }
      }
    }
  }

  void eliminate_inside(const Part& part, Front& front) {
    auto& all = front.unknowns;
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    const auto rest = std::partition(all.begin(), all.end(), [&](std::size_t equation) {
      return part.contains(extents_[equation]);
    });
    for (auto it = all.begin(); it != rest; ++it) order[*it] = next_++;
    front.eliminated = static_cast<std::size_t>(rest - all.begin());
    front.factor = factor;
    const std::size_t columns = FrontMatrix::padded(all.size()) * front.eliminated;
    factor += columns;
    scratch = std::max(scratch, std::max(columns, FrontMatrix::padded(all.size())));
  }

  void finish(Front& front) {
    auto& all = front.unknowns;
    for (std::size_t& unknown : all) unknown = order[unknown];
    std::sort(all.begin(), all.end());
    const auto place = [&](std::size_t unknown) {
      return std::lower_bound(all.begin(), all.end(), unknown) - all.begin();
    };
    for (Front& half : front.halves) {
      finish(half);
      const auto rest = half.unknowns.begin() + static_cast<std::ptrdiff_t>(half.eliminated);
      std::transform(rest, half.unknowns.end(), std::back_inserter(half.places), place);
      front.memory = std::max(front.memory, half.rest_memory() + half.memory);
    }
    for (auto& cell : front.cells) {
      for (int& at : cell.places) {
        if (at >= 0) at = static_cast<int>(place(order[static_cast<std::size_t>(at)]));
      }
    }
  }

  CellEquations cells_;
  std::size_t columns_;
  std::vector<Part> extents_;  // extents of the cells that contribute to an equation
  std::size_t next_ = 0;  // next place in the order of elimination
};

void FrontalSolver::analyze(const CellEquations& cells, std::size_t columns,
                            std::size_t equations) {
  Analysis analysis(cells, columns, equations);
  order_ = std::move(analysis.order);
  whole_ = std::move(analysis.whole);
  factor_.resize(analysis.factor + kTileRows);
  memory_.resize(whole_.memory);
  scratch_.resize(analysis.scratch);
}

bool FrontalSolver::factorize(const std::vector<const double*>& cells) {
  positive_ = true;
  return factorize(whole_, cells, nullptr, memory_.data());
}

bool FrontalSolver::factorize(const Front& front, const std::vector<const double*>& cells,
                              double* rest, double* memory) {
  const FrontMatrix matrix = matrix_of(front, rest);
  std::fill_n(matrix.first, matrix.padded() * matrix.eliminated, 0.0);
  std::fill_n(rest, front.rest_memory(), 0.0);
  for (const auto& cell : front.cells) add_cell(matrix, cell.places, cells[cell.index]);
  for (const Front& half : front.halves) {
    if (!factorize(half, cells, memory, memory + half.rest_memory())) return false;
    add_half(matrix, half.places, memory);
  }
  const auto least = eliminate(matrix, scratch_.data());
  positive_ = positive_ && least && *least > 0;
  return least.has_value();
}

std::vector<double> FrontalSolver::solve(const std::vector<double>& rhs) {
  std::vector<double> x(rhs.size()), result(rhs.size());
  for (std::size_t i = 0; i < rhs.size(); ++i) x[order_[i]] = rhs[i];
  forward(whole_, x);
  backward(whole_, x);
  for (std::size_t i = 0; i < rhs.size(); ++i) result[i] = x[order_[i]];
  return result;
}

FrontMatrix FrontalSolver::matrix_of(const Front& front, double* rest) {
  return {front.unknowns.size(), front.eliminated, factor_.data() + front.factor, rest};
}

// Copies the front's part of x, padded, to scratch_.
double* FrontalSolver::gather(const Front& front, const std::vector<double>& x) {
  const auto& at = front.unknowns;
  for (std::size_t i = 0; i < at.size(); ++i) scratch_[i] = x[at[i]];
  std::fill(scratch_.begin() + static_cast<std::ptrdiff_t>(at.size()),
            scratch_.begin() + static_cast<std::ptrdiff_t>(FrontMatrix::padded(at.size())), 0.0);
  return scratch_.data();
}

void FrontalSolver::forward(const Front& front, std::vector<double>& x) {
  for (const Front& half : front.halves) forward(half, x);
  double* local = gather(front, x);
  solve_forward(matrix_of(front, nullptr), local);
  for (std::size_t i = 0; i < front.unknowns.size(); ++i) x[front.unknowns[i]] = local[i];
}

void FrontalSolver::backward(const Front& front, std::vector<double>& x) {
  double* local = gather(front, x);
  solve_backward(matrix_of(front, nullptr), local);
  for (std::size_t i = 0; i < front.eliminated; ++i) x[front.unknowns[i]] = local[i];
  for (const Front& half : front.halves) backward(half, x);
}

}  // namespace lcrig
