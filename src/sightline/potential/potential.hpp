/// Type-erased potential of any kind, with its weight.
///
/// A potential is a struct with `template <class S> S operator()(...) const` over the Sights of two
/// robots (a coupling) or of one (a constraint of that robot). It may have the time [s] as a last
/// argument:
///
///   S operator()(const Sight<S>& observer, const Sight<S>& target) const;
///   S operator()(const Sight<S>& robot, const S& time) const;
///
/// If it states a limit, it has `double violation(same Sights) const`, with the time as above. The
/// result is > 0 where the limit is violated, in the limit's unit. Its name is `name`, a constant
/// of the type or a function. Its parameters are described by `parameters()` (base/parameter.hpp).
/// Further optional properties are constants or functions:
///
///   limit_unit    unit of the violation, "m"; default: "in its own unit"
///   keeps_apart   whether the limit is a least distance; default: sampled (protection.hpp)
///   observes      whether the first body observes the second; default: it has a sensor and
///                 does not keep the bodies apart
///   mount         the sensor's mount on the observer; a scenario sets it from [agent.NAME.sensor]
///   alpha         with a sensor: the angle of view [rad]
///   d_min, d_max  the limits of the distance [m]
///   sees_third    whether it depends on Sight::third of the first body; default: no
#pragma once

#include <concepts>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/or_nan.hpp"
#include "sightline/base/parameter.hpp"
#include "sightline/formula/trace.hpp"
#include "sightline/model/frames.hpp"
#include "sightline/potential/step.hpp"

namespace sightline {

inline constexpr double half_pi = std::numbers::pi / 2;

/// @throws std::invalid_argument "potential.field = value, expected ..." unless the condition holds
/// and the value is finite
void require(bool holds, std::string_view potential, std::string_view field, double value,
             std::string_view expected);

/// Range of the angles of a field of view.
inline constexpr Bounds acute_angle = {std::numeric_limits<double>::min(), half_pi*(1 - 1e-16),
                                       "in (0, pi/2)"};
/// Largest pitch of a sensor [rad]: straight down, pi/2 rounded up to four digits.
inline constexpr double steepest_mount = 1.5708;
inline constexpr std::string_view mount_pitches = "in [-pi/2, pi/2] rad";

/// @throws std::invalid_argument unless |pitch| <= steepest_mount, the offset is finite and
/// `sigmas` >= 0
void check_mount(std::string_view potential, const SensorMount& mount);

/// Corners of a potential that are smoothed, over a width in the unit of the function with the
/// corner.
struct Rounding {
  double width;
  std::set<std::string> corners;  ///< "abs", "min"
};

template <class P, class S>
concept PairPotentialOver = requires(const P& p, const Sight<S>& a, const S& t) {
  { p(a, a) } -> std::same_as<S>;
}
|| requires(const P& p, const Sight<S>& a, const S& t) {
  { p(a, a, t) } -> std::same_as<S>;
};
template <class P, class S>
concept SinglePotentialOver = requires(const P& p, const Sight<S>& a, const S& t) {
  { p(a) } -> std::same_as<S>;
}
|| requires(const P& p, const Sight<S>& a, const S& t) {
  { p(a, t) } -> std::same_as<S>;
};

/// Potential of two robots.
template <class P>
concept PairPotential = PairPotentialOver<P, double> && PairPotentialOver<P, Symbol>;
/// Potential of one robot.
template <class P>
concept SinglePotential =
    !PairPotential<P> && SinglePotentialOver<P, double> && SinglePotentialOver<P, Symbol>;

/// A potential of any type; immutable and shared. A potential of a single robot ignores the second
/// Sight. If its function throws for numbers, the value is NaN.
class Potential {
 public:
  /// @throws std::invalid_argument for a parameter out of its range, and from the potential's own
  /// check()
  template <class P>
  requires PairPotential<P> || SinglePotential<P> Potential(const P& potential)
      : block_(std::make_shared<const Block<P>>(potential)) {
    if constexpr (Described<P>) check_parameters(potential);
    if constexpr (requires { potential.check(); }) potential.check();
  }

  std::string_view name() const { return block_->name; }
  bool is_pair() const { return block_->is_pair; }
  /// Descriptions of its parameters; empty if the potential does not describe them.
  std::vector<ParameterText> parameters() const { return block_->parameters(); }

  /// l [-] of the observer a and the target b at time t [s].
  double operator()(const Sight<double>& a, const Sight<double>& b, double t) const noexcept {
    return block_->value(a, b, t);
  }
  Symbol operator()(const Sight<Symbol>& a, const Sight<Symbol>& b, const Symbol& t) const {
    return block_->trace(a, b, t);
  }
  /// > 0 where the limit is violated, in the limit's unit; -infinity for a potential without a
  /// limit.
  double violation(const Sight<double>& a, const Sight<double>& b, double t = 0.0) const noexcept {
    return block_->violation(a, b, t);
  }

  /// Least and greatest distance of two bodies [m], if the potential has a field of this name.
  std::optional<double> d_min() const { return block_->d_min(); }
  std::optional<double> d_max() const { return block_->d_max(); }
  /// Angle of view within which the target counts as in view [rad], if the potential has a sensor
  /// and a field of this name.
  std::optional<double> alpha() const { return block_->alpha(); }
  /// Whether it depends on the position of a third body, Sight::third of its first body.
  bool sees_third() const { return block_->sees_third(); }
  /// Unit of its violation: "m", "rad"; default "in its own unit".
  std::string_view limit_unit() const { return block_->limit_unit; }
  /// Declared properties; none if not declared. keeps_apart() and observes() of protection.hpp then
  /// determine them.
  std::optional<bool> says_keeps_apart() const { return block_->keeps_apart; }
  std::optional<bool> says_observes() const { return block_->observes; }
  /// Its limits that all have to hold, each as a potential; empty if it states a single limit.
  std::vector<Potential> conjuncts() const { return block_->conjuncts(); }
  /// Its smoothed corners, if it is a formula that can have some; and a copy with another width.
  std::optional<Rounding> rounding() const { return block_->rounding(); }
  Potential smoothed_over(double width) const { return block_->smoothed_over(width).value_or(*this); }

  /// l over the unit step, with its slope, (34): 0 where the limit holds. NaN if the potential is
  /// not written over a step.
  double sloped(const Sight<double>& a, const Sight<double>& b, double t = 0.0) const {
    return block_->sloped(a, b, t);
  }
  /// Sharpness of its sigmoid, or none.
  std::optional<double> kappa_A() const { return block_->kappa_A(); }
  /// A copy with another sharpness; itself if it has none.
  Potential sharpened(double kappa_A) const { return block_->sharpened(kappa_A).value_or(*this); }
  /// Mount of its sensor on the observer, nullptr without a sensor; and a copy with another mount.
  const SensorMount* mount() const { return block_->mount(); }
  Potential seen_from(const SensorMount& mount) const { return block_->seen_from(mount).value_or(*this); }

  /// The potential as the type that it was constructed from, or nullptr.
  template <class P>
  const P* as() const {
    const auto* block = dynamic_cast<const Block<P>*>(block_.get());
    return block != nullptr ? &block->potential : nullptr;
  }

 private:
  struct Interface {
    std::string_view name = "potential", limit_unit = "in its own unit";
    bool is_pair = true;
    std::optional<bool> keeps_apart{}, observes{};

    virtual ~Interface() = default;
    virtual std::vector<ParameterText> parameters() const = 0;
    virtual double value(const Sight<double>& a, const Sight<double>& b, double t) const noexcept = 0;
    virtual Symbol trace(const Sight<Symbol>& a, const Sight<Symbol>& b, const Symbol& t) const = 0;
    virtual double violation(const Sight<double>& a, const Sight<double>& b, double t) const noexcept = 0;
    virtual std::optional<double> d_min() const = 0;
    virtual std::optional<double> d_max() const = 0;
    virtual std::optional<double> alpha() const = 0;
    virtual bool sees_third() const = 0;
    virtual std::vector<Potential> conjuncts() const = 0;
    virtual std::optional<Rounding> rounding() const = 0;
    virtual std::optional<Potential> smoothed_over(double width) const = 0;
    virtual double sloped(const Sight<double>& a, const Sight<double>& b, double t) const = 0;
    virtual std::optional<double> kappa_A() const = 0;
    virtual std::optional<Potential> sharpened(double kappa_A) const = 0;
    virtual const SensorMount* mount() const = 0;
    virtual std::optional<Potential> seen_from(const SensorMount& mount) const = 0;
  };

  template <class P>
  struct Block final : Interface {
    P potential;

    explicit Block(const P& p) : potential(p) {
      if constexpr (requires { potential.name(); }) {
        this->name = potential.name();
      } else if constexpr (requires { P::name; }) {
        this->name = P::name;
      }
      if constexpr (requires { std::string_view(P::limit_unit); }) this->limit_unit = P::limit_unit;
      if constexpr (requires { bool{P::keeps_apart}; }) this->keeps_apart = P::keeps_apart;
      if constexpr (requires { bool{P::observes}; }) this->observes = P::observes;
      this->is_pair = PairPotential<P>;
    }
    std::vector<ParameterText> parameters() const override { return parameter_texts(potential); }
    template <class S>
    S at(const Sight<S>& a, [[maybe_unused]] const Sight<S>& b, [[maybe_unused]] const S& t) const {
      if constexpr (PairPotential<P>) {
        if constexpr (requires { potential(a, b, t); }) {
          return potential(a, b, t);
        } else {
          return potential(a, b);
        }
      } else {
        if constexpr (requires { potential(a, t); }) {
          return potential(a, t);
        } else {
          return potential(a);
        }
      }
    }
    double value(const Sight<double>& a, const Sight<double>& b, double t) const noexcept override {
      return or_nan([&] { return at<double>(a, b, t); });
    }
    Symbol trace(const Sight<Symbol>& a, const Sight<Symbol>& b, const Symbol& t) const override {
      return at<Symbol>(a, b, t);
    }
    double violation([[maybe_unused]] const Sight<double>& a, [[maybe_unused]] const Sight<double>& b,
                     [[maybe_unused]] double t) const noexcept override {
      if constexpr (requires { potential.violation(a, b, t); }) {
        return or_nan([&] { return potential.violation(a, b, t); });
      } else if constexpr (requires { potential.violation(a, b); }) {
        return or_nan([&] { return potential.violation(a, b); });
      } else if constexpr (requires { potential.violation(a, t); }) {
        return or_nan([&] { return potential.violation(a, t); });
      } else if constexpr (requires { potential.violation(a); }) {
        return or_nan([&] { return potential.violation(a); });
      } else {
        return -std::numeric_limits<double>::infinity();
      }
    }
    std::optional<double> d_min() const override {
      if constexpr (requires { double(potential.d_min); }) return potential.d_min;
      return {};
    }
    std::optional<double> d_max() const override {
      if constexpr (requires { double(potential.d_max); }) return potential.d_max;
      return {};
    }
    std::optional<double> alpha() const override {
      if constexpr (requires { double(potential.alpha); }) {
        if (mount() != nullptr) return potential.alpha;
      }
      return {};
    }
    bool sees_third() const override {
      if constexpr (requires { bool{potential.sees_third()}; }) return potential.sees_third();
      return false;
    }
    std::vector<Potential> conjuncts() const override {
      std::vector<Potential> all;
      if constexpr (requires { potential.conjuncts(); }) {
        for (const auto& one : potential.conjuncts()) all.push_back(Potential(one));
      }
      return all;
    }
    std::optional<Rounding> rounding() const override {
      if constexpr (requires { Rounding{potential.width(), potential.smoothed()}; })
        return Rounding{potential.width(), potential.smoothed()};
      return {};
    }
    std::optional<Potential> smoothed_over([[maybe_unused]] double width) const override {
      if constexpr (requires { Potential(potential.smoothed_over(width)); })
        return Potential(potential.smoothed_over(width));
      return {};
    }
    double sloped([[maybe_unused]] const Sight<double>& a, [[maybe_unused]] const Sight<double>& b,
                  [[maybe_unused]] double t) const override {
      if constexpr (requires { potential.sloped(a, b, t); }) {
        return potential.sloped(a, b, t);
      } else if constexpr (requires { potential.over(UnitStep{}, a, b); }) {
        return potential.over(UnitStep{}, a, b);
      } else if constexpr (requires { potential.over(UnitStep{}, a); }) {
        return potential.over(UnitStep{}, a);
      } else {
        return std::numeric_limits<double>::quiet_NaN();
      }
    }
    std::optional<double> kappa_A() const override {
      if constexpr (requires { potential.kappa_A(); }) {
        return potential.kappa_A();
      } else if constexpr (requires { std::optional<double>(potential.kappa_A); }) {
        return potential.kappa_A;
      } else {
        return {};
      }
    }
    std::optional<Potential> sharpened([[maybe_unused]] double kappa_A) const override {
      if constexpr (requires { Potential(potential.sigmoid(kappa_A)); }) {
        return Potential(potential.sigmoid(kappa_A));
      } else if constexpr (requires(P p) { p.kappa_A = kappa_A; }) {
        P other = potential;
        other.kappa_A = kappa_A;
        return Potential(other);
      } else {
        return {};
      }
    }
    const SensorMount* mount() const override {
      if constexpr (requires { potential.is_view(); }) {
        return potential.is_view() ? &potential.mount() : nullptr;
      } else if constexpr (requires(const SensorMount* m) { m = &potential.mount; }) {
        return &potential.mount;
      } else {
        return nullptr;
      }
    }
    std::optional<Potential> seen_from([[maybe_unused]] const SensorMount& mount) const override {
      if constexpr (requires { Potential(potential.seen_from(mount)); }) {
        return Potential(potential.seen_from(mount));
      } else if constexpr (requires(P p) { p.mount = mount; }) {
        P other = potential;
        other.mount = mount;
        return Potential(other);
      } else {
        return {};
      }
    }
  };

  std::shared_ptr<const Interface> block_;
};

/// A potential multiplied by its weight k: `0.4 * SensorCone{}`.
struct Weighted {
  double weight = 1.0;
  Potential potential;
};

template <class P>
requires PairPotential<P> || SinglePotential<P> Weighted operator*(double weight, const P& potential) {
  return {weight, potential};
}

}  // namespace sightline
