// Prints a hash over many arguments of each function of the C library that is called. Lines that
// differ between machines show bits of the machine's own. scripts/arm64.sh compares them.
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>

namespace {

constexpr int arguments = 500'000;

template <class Function>
void print(const char* name, double low, double high, Function function) {
  std::mt19937_64 random(1);
  std::uint64_t hash = 14695981039346656037ull;
  const auto draw = [&] {
    const double share = static_cast<double>(random() >> 11) * 0x1p-53;
    // Half of them near zero, on a scale of its own.
    const double near = random() % 2 == 0 ? 1.0 : std::exp2(-static_cast<double>(random() % 40));
    return low + (high - low) * share * near;
  };
  for (int i = 0; i < arguments; ++i) {
    const double a = draw(), b = draw();
    hash = (hash ^ std::bit_cast<std::uint64_t>(function(a, b))) * 1099511628211ull;
  }
  std::printf("%s %016llx\n", name, static_cast<unsigned long long>(hash));
}

}  // namespace

int main() {
  print("sin", -20, 20, [](double a, double) { return std::sin(a); });
  print("cos", -20, 20, [](double a, double) { return std::cos(a); });
  print("tan", -1.6, 1.6, [](double a, double) { return std::tan(a); });
  print("asin", -1, 1, [](double a, double) { return std::asin(a); });
  print("acos", -1, 1, [](double a, double) { return std::acos(a); });
  print("atan", -9, 9, [](double a, double) { return std::atan(a); });
  print("atan2", -9, 9, [](double a, double b) { return std::atan2(a, b); });
  print("exp", -40, 40, [](double a, double) { return std::exp(a); });
  print("log", 0, 1000, [](double a, double) { return std::log(a); });
  print("log1p", -0.9, 9, [](double a, double) { return std::log1p(a); });
  print("pow", 0, 9, [](double a, double b) { return std::pow(a, b - 3); });
}
