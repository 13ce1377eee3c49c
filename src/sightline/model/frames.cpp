#include <algorithm>
#include <cmath>

#include "sightline/model.hpp"

namespace sightline {

// atan2 keeps its accuracy near the axis, where acos(x / |p|) loses half the digits.
double off_axis(const Vec3<double>& p_S) { return std::atan2(norm(p_S.y, p_S.z), p_S.x); }

}  // namespace sightline
