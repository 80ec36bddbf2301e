// SPDX-License-Identifier: Apache-2.0
// Functions that have geometry as a scene has it: what is hard to find by colour, or by few samples.
#include <triad/sampling/areas.hpp>
#include <triad/sampling/function_base.hpp>

namespace triad {
namespace {

constexpr float kDistance = 5;  // of the ground from the eye, in picture heights
constexpr uint32_t kGroundId = 1, kShapeId = 2;

struct Surface {
  float light = 0, distance = kDistance;
  uint32_t id = kGroundId;
};

// A shape before a ground, both upright sheets seen by parallel rays along -z. Scene coordinates are picture heights
// about the picture's middle, y up; the eye's plane is z = 0.
template <class Shape>
class ShapeSource final : public AnalyticSource {
 public:
  ShapeSource(const View& view, const Shape& shape, const Surface& ground, const Surface& in_front)
      : AnalyticSource(view), shape_(shape), ground_(ground), in_front_(in_front) {}
  SourceAbilities abilities() const override {
    return {.geometry = true, .exact_integral = true, .deterministic = true};
  }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    const double per_x = view().cells.x, per_y = view().cells.y;
    for (size_t i = 0; i < requests.size(); ++i) {
      const double x = requests[i].x / per_x, y = requests[i].y / per_y;
      const Surface& surface = shape_.covers(x, y) ? in_front_ : ground_;
      const float albedo = std::min(surface.light, 1.f);
      samples[i] = {.rgb = {surface.light, surface.light, surface.light},
                    .distance = surface.distance,
                    .position = {static_cast<float>((x - .5 * width_px()) / height_px()),
                                 static_cast<float>((.5 * height_px() - y) / height_px()), -surface.distance},
                    .normal = {0, 0, 1},
                    .albedo = {albedo, albedo, albedo},
                    .object_id = surface.id,
                    .material_id = surface.id};
    }
  }

 private:
  std::array<double, 3> mean(const Box& box) const override {
    const double share = shape_.area(box) / box.area();
    const double light = share * in_front_.light + (1 - share) * ground_.light;
    return {light, light, light};
  }

  Shape shape_;
  Surface ground_, in_front_;
};

struct LeftSide {
  Turned turned;
  double edge_px;
  bool covers(double x, double y) const { return turned.u(x, y) < edge_px; }
  template <class Box>
  double area(const Box& box) const {
    return box.area() * half_plane_share(box.x1 - box.x0, box.y1 - box.y0, turned.cosine, turned.sine,
                                         edge_px - turned.u(box.x0, box.y0));
  }
};

struct Disc {
  double x, y, radius_px;
  bool covers(double at_x, double at_y) const {
    const double dx = at_x - x, dy = at_y - y;
    return dx * dx + dy * dy < radius_px * radius_px;
  }
  template <class Box>
  double area(const Box& box) const {
    const double r = radius_px;
    return r * r * unit_disc_area((box.x0 - x) / r, (box.y0 - y) / r, (box.x1 - x) / r, (box.y1 - y) / r);
  }
};

const FunctionInfo kWhiteOnWhite{
    "white-on-white",
    "an edge that no colour shows",
    "A white sheet before a white ground: the same light everywhere, but other ids, and a step in depth. A strategy "
    "that looks at colours alone spends nothing on it, one that looks at ids or positions finds the edge; the "
    "picture "
    "is right either way.",
    {angle_param(20),
     shift_param(),
     rows_param(),
     choice_param("tell", "what differs between the two", {"both", "ids", "position"}),
     {"step", "how far the sheet is before the ground, in picture heights", .001, 4, .5, true}}};

std::unique_ptr<Source> make_white_on_white(const StrategyValues& values, const View& view, const std::string&) {
  constexpr double kIdsAlone = 1, kPositionAlone = 2;
  const double tell = values.at("tell");
  const Surface ground{.light = 1};
  Surface sheet{.light = 1, .id = kShapeId};
  if (tell != kIdsAlone) sheet.distance -= static_cast<float>(values.at("step"));
  if (tell == kPositionAlone) sheet.id = kGroundId;
  const LeftSide side{Turned(view, values.at("angle")), length_px(values, "shift", view)};
  return std::make_unique<ShapeSource<LeftSide>>(view, side, ground, sheet);
}

StrategyParam place_param(const std::string& name, const std::string& of, double usual) {
  return {name, "the disc's middle, in shares of the picture's " + of, -10, 10, usual, true};
}
StrategyParam radius_param(double usual_px) { return {"radius", "pixels", 1e-6, 1e5, usual_px, true}; }

std::unique_ptr<Source> make_disc(const StrategyValues& values, const View& view, double low, double high) {
  constexpr float kBefore = .5;  // picture heights
  const Disc disc{values.at("x") * view.width_px, values.at("y") * view.height_px, length_px(values, "radius", view)};
  const Surface ground{.light = static_cast<float>(low)};
  const Surface object{.light = static_cast<float>(high), .distance = kDistance - kBefore, .id = kShapeId};
  return std::make_unique<ShapeSource<Disc>>(view, disc, ground, object);
}

const FunctionInfo kSmallObject{
    "small-object", "one disc, small enough to lie between the first samples of coarse strategies",
    "Brighter than its ground, nearer and with an id of its own. A strategy that begins with one sample in many "
    "pixels and refines where neighbours differ misses it if no sample meets it: that is expected, and shown here. "
    "Where the samples lie depends on the picture's size: by default, quad misses it in 400x225 pixels, and finds it "
    "in 404x228.",
    with_tones({radius_param(.9), place_param("x", "width", .5), place_param("y", "height", .5), rows_param()})};

std::unique_ptr<Source> make_small_object(const StrategyValues& values, const View& view, const std::string&) {
  return make_disc(values, view, values.at("low"), values.at("high"));
}

const FunctionInfo kSpeck{
    "speck",
    "one speck of light, bright and far smaller than a pixel",
    "What a lamp's reflection in a far chrome rail is. With the default it adds pi .05^2 1000 = 7.9 to the pixel "
    "that it is in, or to those together on whose border it lies, as it does in pictures 500 pixels wide; few "
    "strategies ever meet it, and those that do, show a firefly.",
    {{"level", "its light", 0, 1e9, 1000, true},
     radius_param(.05),
     place_param("x", "width", .502),
     place_param("y", "height", .503),
     rows_param()}};

std::unique_ptr<Source> make_speck(const StrategyValues& values, const View& view, const std::string&) {
  return make_disc(values, view, 0, values.at("level"));
}

}  // namespace

const FunctionEntry& white_on_white_function() {
  static const FunctionEntry entry{kWhiteOnWhite, make_white_on_white};
  return entry;
}

const FunctionEntry& small_object_function() {
  static const FunctionEntry entry{kSmallObject, make_small_object};
  return entry;
}

const FunctionEntry& speck_function() {
  static const FunctionEntry entry{kSpeck, make_speck};
  return entry;
}

}  // namespace triad
