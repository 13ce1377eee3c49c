/// Transposition of W packs of W lanes: from one entry of all robots per pack to one robot per
/// pack.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "sightline/base/lane.hpp"

namespace sightline {
namespace detail {

/// Exchanges the lanes of b whose index lacks bit S with the lanes of a whose index has it.
template <int S, int W>
void exchange(Lane<W>& a, Lane<W>& b) {
  using L = Lane<W>;
  const auto exchanged = [&]<int... i>(std::integer_sequence<int, i...>) {
#if defined(__clang__)
    return std::pair{L(typename L::Vector{((i & S) == 0 ? a.v[i] : b.v[i - S])...}),
                     L(typename L::Vector{((i & S) == 0 ? a.v[i + S] : b.v[i])...})};
#else
    return std::pair{L(__builtin_shuffle(a.v, b.v, typename L::Bits{((i & S) == 0 ? i : W + i - S)...})),
                     L(__builtin_shuffle(a.v, b.v, typename L::Bits{((i & S) == 0 ? i + S : W + i)...}))};
#endif
  }
  (std::make_integer_sequence<int, W>());
  a = exchanged.first;
  b = exchanged.second;
}

template <int S, int W>
void transpose_by(std::array<Lane<W>, static_cast<std::size_t>(W)>& rows) {
  constexpr auto apart = static_cast<std::size_t>(S);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if ((i & apart) == 0) exchange<S>(rows[i], rows[i + apart]);
  }
  if constexpr (2 * S < W) transpose_by<2 * S>(rows);
}

}  // namespace detail

/// Exchanges lane j of rows[i] with lane i of rows[j].
template <int W>
void transpose(std::array<Lane<W>, static_cast<std::size_t>(W)>& rows) {
  if constexpr (W > 1) detail::transpose_by<1>(rows);
}

/// Stores the first `count` numbers of a pack, 0 <= count <= W.
template <int W>
void store_first(Lane<W> pack, int count, double* to) {
#if defined(__AVX512F__)
  if constexpr (W == 8) {
    _mm512_mask_storeu_pd(to, static_cast<__mmask8>((1U << count) - 1), (__m512d)pack.v);
    return;
  }
#endif
  for (int i = 0; i < count; ++i) to[i] = pack[i];
}

}  // namespace sightline
