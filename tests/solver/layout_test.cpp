#include "sightline/solver/newton/layout.hpp"

#include <gtest/gtest.h>

#include <set>

namespace sightline {
namespace {

TEST(Layout, EveryNumberOfEveryAgentHasAPlaceOfItsOwn) {
  Layout layout{.stages = 7, .width = 4};
  layout.add(4, 5);
  layout.add(2, 8);
  layout.agents = {{0, 0}, {1, 0}, {0, 1}, {1, 3}, {0, 3}};
  std::set<std::ptrdiff_t> u, s, c;
  std::size_t n_u = 0, n_s = 0, n_c = 0;
  for (int a = 0; a < 5; ++a) {
    const Layout::Part& part = layout.part(a);
    for (int k = 0; k < layout.stages; ++k) {
      for (int i = 0; i < part.nu; ++i, ++n_u) u.insert(layout.u(a)(k, i));
      for (int i = 0; i < part.ns; ++i, ++n_s) s.insert(layout.s(a)(k, i));
      for (int i = 0; i < part.nc(); ++i, ++n_c) c.insert(layout.c(a)(k, i));
    }
  }
  EXPECT_EQ(u.size(), n_u);
  EXPECT_EQ(s.size(), n_s);
  EXPECT_EQ(c.size(), n_c);
  EXPECT_LT(*u.rbegin(), layout.u_length);
  EXPECT_LT(*s.rbegin(), layout.s_length);
  EXPECT_LT(*c.rbegin(), layout.c_length);
}

TEST(Layout, PartsBeginOnWholePacks) {
  Layout layout{.stages = 3, .width = 2};
  for (const int nu : {1, 3, 5}) layout.add(nu, 5);
  for (const Layout::Part& part : layout.groups) {
    EXPECT_EQ(part.u % row_quantum, 0);
    EXPECT_EQ(part.s % row_quantum, 0);
    EXPECT_EQ(part.c % row_quantum, 0);
  }
}

}  // namespace
}  // namespace sightline
