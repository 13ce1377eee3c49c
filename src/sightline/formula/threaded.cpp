#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/formula/operation.hpp"

namespace sightline {
namespace {

// A step is a first instruction or a link to the previous step's result, then up to two more links.
constexpr std::array<Code, 6> firsts = {Code::add,          Code::subtract,          Code::multiply,
                                        Code::multiply_add, Code::multiply_subtract, Code::subtract_product};
enum class Link {
  none,
  add,               ///< r + a
  subtract,          ///< r - a
  multiply_add,      ///< a b + r
  subtract_product,  ///< r - a b
};
constexpr int links = 5, longest_chain = 3;
constexpr int shapes = (static_cast<int>(firsts.size()) + links) * links * links;

/// A value is an input or a constant, by its row, or the result of instruction i: first_scratch +
/// i.
struct Single {
  Code code{};
  std::array<int, 3> operands{};
  int output = -1;  ///< the output it writes, if no instruction reads it
};

/// The link by which an instruction continues a value, and its other operands; none if it cannot.
struct Continuation {
  Link link = Link::none;
  int a = -1, b = -1;
};
Continuation continuation(const Single& q, int value) {
  const auto [a, b, c] = q.operands;
  switch (q.code) {
    case Code::add:
      if (a == b) return {};
      if (a == value) return {Link::add, b};
      return b == value ? Continuation{Link::add, a} : Continuation{};
    case Code::subtract:
      return a == value && b != value ? Continuation{Link::subtract, b} : Continuation{};
    case Code::multiply_add:
    case Code::subtract_product:
      if (c != value || a == value || b == value) return {};
      return {q.code == Code::multiply_add ? Link::multiply_add : Link::subtract_product, a, b};
    default:
      return {};
  }
}

/// Instructions in sequence; each continues the result of the previous one.
struct Chain {
  int first = 0, last = 0;
  double ready = 0.0, height = 0.0;  // cycles: when its operands are ready; from here to the end
  int waits_for = 0;                 // operands that are not yet computed
  std::vector<int> readers{};        // chains
};

/// A program in static single assignment form, in chains, in their order of execution.
class Schedule {
 public:
  explicit Schedule(const Program& program) : base_(program.first_scratch()) {
    number_values(program);
    chain_up();
    order();
  }

  const Single& single(int i) const { return singles_[at(i)]; }
  std::span<const Chain> chains() const { return chains_; }
  std::span<const int> in_order() const { return order_; }
  int value(int instruction) const { return base_ + instruction; }
  bool is_result(int v) const { return v >= base_; }
  int reads(int v) const { return reads_[at(v - base_)]; }

 private:
  void number_values(const Program& program) {
    std::vector<int> in_row(at(program.rows()));
    for (int r = 0; r < base_; ++r) in_row[at(r)] = r;
    for (const Instruction& q : program.instructions()) {
      Single s{q.code, {-1, -1, -1}, q.d >= program.first_output() ? q.d - program.first_output() : -1};
      const std::array<int, 3> rows = {q.a, q.b, q.c};
      for (int o = 0; o < operand_count(q.code); ++o) s.operands[at(o)] = in_row[at(rows[at(o)])];
      in_row[at(q.d)] = value(static_cast<int>(singles_.size()));
      singles_.push_back(s);
    }
    count_reads();
    // An output that copies a result is written directly, if nothing else reads that result.
    for (Single& s : singles_) {
      const int from = s.operands[0];
      if (s.code != Code::copy || s.output < 0 || !is_result(from) || reads(from) != 1) continue;
      singles_[at(from - base_)].output = s.output;
      s.operands[0] = -1;
    }
    count_reads();
  }

  void count_reads() {
    reads_.assign(singles_.size(), 0);
    for (const Single& s : singles_) {
      for (const int v : s.operands) {
        if (v >= 0 && is_result(v)) ++reads_[at(v - base_)];
      }
    }
  }

  void chain_up() {
    const int n = static_cast<int>(singles_.size());
    chain_of_.assign(at(n), -1);
    for (int i = 0; i < n;) {
      Chain chain{i, i};
      const bool dropped = single(i).code == Code::copy && single(i).operands[0] < 0;
      while (chain.last + 1 < n && reads(value(chain.last)) == 1 &&
             continuation(single(chain.last + 1), value(chain.last)).link != Link::none) {
        ++chain.last;
      }
      i = chain.last + 1;
      if (dropped) continue;
      for (int k = chain.first; k <= chain.last; ++k) chain_of_[at(k)] = static_cast<int>(chains_.size());
      chains_.push_back(std::move(chain));
    }
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      for (int k = chains_[c].first; k <= chains_[c].last; ++k) {
        for (const int v : single(k).operands) {
          if (v < 0 || !is_result(v)) continue;
          const int from = chain_of_[at(v - base_)];
          if (from == static_cast<int>(c)) continue;
          chains_[at(from)].readers.push_back(static_cast<int>(c));
          ++chains_[c].waits_for;
        }
      }
    }
  }

  /// List scheduling: among the chains with ready operands, the one with the longest path to the
  /// end first.
  void order() {
    constexpr double step = 5.0, instruction = 4.0, through_memory = 12.0;  // approximate cycles
    const auto takes = [&](const Chain& c) { return through_memory + instruction * (c.last - c.first + 1); };
    for (std::size_t c = chains_.size(); c-- > 0;) {
      Chain& chain = chains_[c];
      for (const int r : chain.readers) chain.height = std::max(chain.height, chains_[at(r)].height);
      chain.height += takes(chain);
    }
    std::vector<int> open;
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      if (chains_[c].waits_for == 0) open.push_back(static_cast<int>(c));
    }
    for (double now = 0.0; !open.empty(); now += step) {
      const auto better = [&](int a, int b) {
        const Chain &x = chains_[at(a)], &y = chains_[at(b)];
        if ((x.ready <= now) != (y.ready <= now)) return x.ready <= now;
        return x.ready <= now ? x.height > y.height : x.ready < y.ready;
      };
      const auto next = std::min_element(open.begin(), open.end(), better);
      const int c = *next;
      open.erase(next);
      order_.push_back(c);
      for (const int r : chains_[at(c)].readers) {
        Chain& reader = chains_[at(r)];
        reader.ready = std::max(reader.ready, now + takes(chains_[at(c)]));
        if (--reader.waits_for == 0) open.push_back(r);
      }
    }
  }

  int base_;
  std::vector<Single> singles_;
  std::vector<int> reads_, chain_of_, order_;
  std::vector<Chain> chains_;
};

}  // namespace

template <int W>
auto Threaded<W>::place(std::size_t block, int row) -> Place {
  assert(row * W < 1 << number_bits && block < 1u << (32 - number_bits) && "a place has room for both");
  return static_cast<Place>(block << number_bits | static_cast<std::size_t>(row * W));
}

template <int W>
template <int shape>
void Threaded<W>::run_chain(Vector before, const Step* step, double* const* blocks) {
  constexpr int beginning = shape / links / links;
  const Place* o = step->operands.data();
  const auto next = [&] { return L::load(address(*o++, blocks)); };
  L r(before);
  const auto go_on = [&]<Link link>() {
    if constexpr (link == Link::add) r = r + next();
    if constexpr (link == Link::subtract) r = r - next();
    if constexpr (link == Link::multiply_add || link == Link::subtract_product) {
      const L x = next(), y = next();
      r = link == Link::multiply_add ? fma(x, y, r) : subtract_product(x, y, r);
    }
  };
  if constexpr (beginning < static_cast<int>(firsts.size())) {
    constexpr Code first = firsts[at(beginning)];
    const L a = next(), b = next();
    if constexpr (operand_count(first) == 3) r = operation<first, L>(a, b, next());
    if constexpr (operand_count(first) == 2) r = operation<first, L>(a, b, b);
  } else {
    go_on.template operator()<static_cast<Link>(beginning - static_cast<int>(firsts.size()))>();
  }
  go_on.template operator()<static_cast<Link>(shape / links % links)>();
  go_on.template operator()<static_cast<Link>(shape % links)>();
  r.store(address(step->d, blocks));
  return step[1].run(r.v, step + 1, blocks);
}

template <int W>
template <Code code>
void Threaded<W>::run_alone(Vector, const Step* step, double* const* blocks) {
  const L a = L::load(address(step->operands[0], blocks));
  const L b = operand_count(code) > 1 ? L::load(address(step->operands[1], blocks)) : a;
  const L r = operation<code, L>(a, b, b);
  r.store(address(step->d, blocks));
  return step[1].run(r.v, step + 1, blocks);
}

template <int W>
Threaded<W>::Threaded(const Program& program, std::span<const int> inputs, std::span<const int> outputs)
    : blocks_{nullptr} {
  using Function = void (*)(Vector, const Step*, double* const*);
  constexpr auto of_chain = []<std::size_t... i>(std::index_sequence<i...>) {
    return std::array<Function, shapes>{&Threaded::run_chain<static_cast<int>(i)>...};
  }
  (std::make_index_sequence<shapes>());
  constexpr auto of_code = []<std::size_t... i>(std::index_sequence<i...>) {
    return std::array<Function, codes>{&Threaded::run_alone<static_cast<Code>(i)>...};
  }
  (std::make_index_sequence<codes>());
  const auto places = [&](std::span<const int> blocks, std::vector<Place>& list) {
    for (const int rows : blocks) {
      for (int i = 0; i < rows; ++i) list.push_back(place(blocks_.size(), i));
      blocks_.push_back(nullptr);
    }
  };
  std::vector<Place> of_value, of_output;
  places(inputs, of_value);
  places(outputs, of_output);
  assert(static_cast<int>(of_value.size()) == program.inputs() && "blocks hold all inputs");
  assert(static_cast<int>(of_output.size()) == program.outputs() && "blocks hold all outputs");
  const int constants = static_cast<int>(program.constants().size());
  for (int i = 0; i < constants; ++i) of_value.push_back(place(0, i));

  const Schedule schedule(program);
  of_value.resize(of_value.size() + program.instructions().size());
  std::vector<int> reads_left(program.instructions().size());
  std::vector<Place> free;
  int rows = constants;
  for (const int c : schedule.in_order()) {
    const Chain& chain = schedule.chains()[at(c)];
    Place d = 0;
    if (const int output = schedule.single(chain.last).output; output >= 0) {
      d = of_output[at(output)];
    } else if (!free.empty()) {
      d = free.back();
      free.pop_back();
    } else {
      d = place(0, rows++);
    }
    of_value[at(schedule.value(chain.last))] = d;
    reads_left[at(chain.last)] = schedule.reads(schedule.value(chain.last));
    std::vector<Place> freed;
    for (int k = chain.first; k <= chain.last;) {
      Step step;
      step.d = d;
      auto operand = step.operands.begin();
      const auto read = [&](int value) {
        *operand++ = of_value[at(value)];
        const int i = value - schedule.value(0);
        if (i < 0 || --reads_left[at(i)] > 0) return;
        if (of_value[at(value)] >> number_bits == 0) freed.push_back(of_value[at(value)]);
      };
      const auto link = [&](int to) {
        const Continuation next = continuation(schedule.single(to), schedule.value(to - 1));
        read(next.a);
        if (next.b >= 0) read(next.b);
        return static_cast<int>(next.link);
      };
      const Single& first = schedule.single(k);
      const auto in_chain = std::find(firsts.begin(), firsts.end(), first.code);
      int shape = static_cast<int>(in_chain - firsts.begin());
      if (k > chain.first) {
        shape = static_cast<int>(firsts.size()) + link(k);
      } else {
        for (int o = 0; o < operand_count(first.code); ++o) read(first.operands[at(o)]);
      }
      step.run = in_chain == firsts.end() ? of_code[static_cast<std::size_t>(first.code)] : nullptr;
      ++k;
      if (step.run == nullptr) {
        for (int length = 1; length < longest_chain; ++length)
          shape = shape * links + (k <= chain.last ? link(k++) : static_cast<int>(Link::none));
        step.run = of_chain[at(shape)];
      }
      steps_.push_back(step);
    }
    free.insert(free.end(), freed.begin(), freed.end());
  }
  steps_.push_back({.run = finish});
  own_ = Rows(1, W * rows);
  for (int i = 0; i < constants; ++i) std::fill_n(own_[0] + i * W, W, program.constants()[at(i)]);
  blocks_[0] = own_[0];
}

template <int W>
void Threaded<W>::run(std::initializer_list<const double*> inputs,
                      std::initializer_list<double*> outputs) noexcept {
  assert(1 + inputs.size() + outputs.size() == blocks_.size() && "one pointer for each block");
  double** block = &blocks_[1];
  for (const double* b : inputs) *block++ = const_cast<double*>(b);  // never written
  for (double* b : outputs) *block++ = b;
  steps_[0].run(Vector{}, steps_.data(), blocks_.data());
}

template class Threaded<1>;
template class Threaded<2>;
template class Threaded<4>;
template class Threaded<8>;

}  // namespace sightline
