#include "stand_ins.h"

#include "stand_in_maker.h"

#include <algorithm>
#include <cmath>

#include <earpoint/scene/material_table.h>

namespace earpoint {

Surface StandInMaker::textured(const std::string& key, const std::string& acoustic,
                               TexturePattern pattern, const ScreenColour& colour,
                               float roughness) {
  Surface found;
  if (builder_.find_surface(key, found)) return found;
  Material material{.acoustic = standard_material(acoustic), .look = {}};
  material.look.base_colour = {1.0F, 1.0F, 1.0F};
  material.look.roughness = roughness;
  material.look.texture = builder_.add_texture(make_texture(pattern, colour, style_.seed));
  return builder_.add_surface(key, material, texture_span_m(pattern));
}

Surface StandInMaker::flat(const std::string& key, const std::string& acoustic,
                           const ScreenColour& colour, float roughness) {
  Material material{.acoustic = standard_material(acoustic), .look = {}};
  material.look.base_colour = linear_colour(colour);
  material.look.roughness = roughness;
  return builder_.add_surface(key, material);
}

Surface StandInMaker::wood() {
  return textured("wood", "furniture_wood", TexturePattern::wood_grain, style_.wood, 0.6F);
}
Surface StandInMaker::panel() {
  return textured("panel", "furniture_thin_panel", TexturePattern::wood_grain, style_.wood, 0.6F);
}
Surface StandInMaker::upholstery() {
  if (style_.leather) {
    return textured("leather", "upholstery_leather", TexturePattern::leather, style_.fabric, 0.5F);
  }
  return textured("fabric", "upholstery_fabric", TexturePattern::fabric, style_.fabric);
}
Surface StandInMaker::cushion() {
  return textured("cushion", "upholstery_fabric", TexturePattern::fabric, style_.accent);
}
Surface StandInMaker::bedding() {
  return textured("bedding", "bedding", TexturePattern::fabric, style_.bedding);
}
Surface StandInMaker::linen() { return flat("linen", "bedding", {0.93F, 0.92F, 0.9F}, 0.9F); }
Surface StandInMaker::metal() { return flat("metal", "metal_sheet", {0.62F, 0.63F, 0.65F}, 0.35F); }
Surface StandInMaker::white() { return flat("white", "metal_sheet", {0.92F, 0.92F, 0.91F}, 0.4F); }
Surface StandInMaker::ceramic() {
  return flat("ceramic", "ceramic_ware", {0.95F, 0.95F, 0.94F}, 0.25F);
}
Surface StandInMaker::screen() { return flat("screen", "glass", {0.05F, 0.05F, 0.06F}, 0.2F); }
Surface StandInMaker::plastic() { return flat("plastic", "plastic", {0.15F, 0.15F, 0.16F}, 0.5F); }
Surface StandInMaker::stone() {
  return textured("worktop", "marble", TexturePattern::marble, {0.6F, 0.58F, 0.56F}, 0.35F);
}
Surface StandInMaker::shade() {
  Material material{.acoustic = standard_material("curtain_light"), .look = {}};
  material.look.base_colour = {0.9F, 0.85F, 0.75F};
  material.look.emission = {1.2F, 1.05F, 0.8F};
  return builder_.add_surface("shade", material);
}

void StandInMaker::box(double x0, double x1, double y0, double y1, double z0, double z1,
                       Surface surface) {
  builder_.add_box({x0, y0, z0}, {x1, y1, z1}, surface);
}

void StandInMaker::legs(double height_m, double thickness_m, double inset_m, Surface surface) {
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const double x = sx * (d_ / 2 - inset_m - thickness_m / 2);
      const double y = sy * (w_ / 2 - inset_m - thickness_m / 2);
      box(x - thickness_m / 2, x + thickness_m / 2, y - thickness_m / 2, y + thickness_m / 2, 0,
          height_m, surface);
    }
  }
}

void StandInMaker::front_picture(double z0, double z1, double rim_m, Surface picture) {
  const double x = d_ / 2;
  const double half = w_ / 2 - rim_m;
  builder_.add_quad({Vector3{x, -half, z0 + rim_m}, Vector3{x, half, z0 + rim_m},
                     Vector3{x, half, z1 - rim_m}, Vector3{x, -half, z1 - rim_m}},
                    picture, {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}});
}

void StandInMaker::make(FurnitureKind kind) {
  using enum FurnitureKind;
  switch (kind) {
    case sofa:
    case armchair:
      return build_seat();
    case coffee_table:
      return build_table(0.05);
    case dining_table:
    case desk:
      return build_table(0.035);
    case tv_stand:
    case dresser:
      return build_cupboard(2, 3, wood());
    case bedside_table:
      return build_cupboard(1, 2, wood());
    case wardrobe:
      return build_cupboard(std::max(2, static_cast<int>(w_ / 0.55)), 1, panel());
    case wall_cabinet:
      return build_cupboard(std::max(1, static_cast<int>(w_ / 0.45)), 1, wood());
    case television:
      return build_television();
    case bookcase:
    case shelf:
      return build_bookcase();
    case rug:
      return build_rug();
    case floor_lamp:
      return build_lamp(0.14);
    case table_lamp:
      return build_lamp(0.06);
    case ceiling_lamp:
      return build_ceiling_lamp();
    case plant:
      return build_plant();
    case piano:
      return build_piano();
    case chair:
      return build_chair();
    case stool:
      return build_stool();
    case bed:
      return build_bed();
    case office_chair:
      return build_office_chair();
    case computer:
      return build_computer();
    case kitchen_base:
      return build_kitchen_base(false, false);
    case kitchen_sink:
      return build_kitchen_base(true, false);
    case stove:
      return build_kitchen_base(false, true);
    case fridge:
      return build_fridge();
    case washing_machine:
      return build_washing_machine();
    case bathtub:
      return build_bathtub();
    case toilet:
      return build_toilet();
    case washbasin:
      return build_washbasin();
    case towel_rack:
      return box(-d_ / 2, d_ / 2, -w_ / 2, w_ / 2, 0.0, h_,
                 textured("towel", "upholstery_fabric", TexturePattern::fabric, style_.accent));
    case radiator:
      return build_radiator();
    case curtain:
      return build_curtain();
    case blinds:
      return build_blinds();
    case picture:
      return build_framed(
          textured("painting", "glass", TexturePattern::painting, style_.accent, 0.4F));
    case mirror:
      return build_framed(flat("mirror", "glass", {0.8F, 0.83F, 0.85F}, 0.05F));
  }
}

SizeRange stand_in_sizes(FurnitureKind kind) {
  using enum FurnitureKind;
  switch (kind) {
    case sofa:
      return {{0.82, 1.45, 0.78}, {0.98, 2.3, 0.92}};
    case armchair:
      return {{0.78, 0.75, 0.8}, {0.92, 0.95, 1.0}};
    case coffee_table:
      return {{0.45, 0.8, 0.38}, {0.7, 1.2, 0.48}};
    case tv_stand:
      return {{0.36, 1.0, 0.42}, {0.48, 1.6, 0.58}};
    case television:
      return {{0.2, 0.75, 0.5}, {0.25, 1.25, 0.8}};
    case bookcase:
      return {{0.28, 0.7, 1.5}, {0.38, 1.2, 2.1}};
    case shelf:
      return {{0.25, 0.6, 0.8}, {0.35, 1.0, 1.3}};
    case rug:
      return {{1.2, 1.6, 0.009}, {2.0, 2.9, 0.012}};
    case floor_lamp:
      return {{0.35, 0.35, 1.45}, {0.45, 0.45, 1.7}};
    case table_lamp:
      return {{0.22, 0.22, 0.35}, {0.3, 0.3, 0.5}};
    case ceiling_lamp:
      return {{0.3, 0.3, 0.09}, {0.5, 0.5, 0.14}};
    case plant:
      return {{0.4, 0.4, 0.6}, {0.7, 0.7, 1.4}};
    case piano:
      return {{0.6, 1.4, 1.2}, {0.65, 1.5, 1.3}};
    case dining_table:
      return {{0.75, 0.8, 0.72}, {1.0, 1.8, 0.77}};
    case chair:
      return {{0.44, 0.42, 0.85}, {0.5, 0.48, 0.98}};
    case stool:
      return {{0.35, 0.35, 0.45}, {0.45, 0.45, 0.48}};
    case bed:
      return {{1.98, 0.9, 0.85}, {2.1, 1.8, 1.15}};
    case bedside_table:
      return {{0.36, 0.4, 0.45}, {0.45, 0.5, 0.58}};
    case wardrobe:
      return {{0.55, 0.9, 1.9}, {0.65, 2.2, 2.2}};
    case dresser:
      return {{0.42, 0.8, 0.75}, {0.5, 1.4, 0.95}};
    case desk:
      return {{0.6, 1.1, 0.72}, {0.8, 1.7, 0.76}};
    case office_chair:
      return {{0.58, 0.58, 0.9}, {0.64, 0.64, 1.1}};
    case computer:
      return {{0.45, 0.5, 0.4}, {0.5, 0.6, 0.48}};
    case kitchen_base:
      return {{0.6, 0.45, 0.9}, {0.6, 1.2, 0.9}};
    case kitchen_sink:
      return {{0.6, 0.6, 0.9}, {0.6, 0.9, 0.9}};
    case stove:
      return {{0.6, 0.6, 0.9}, {0.6, 0.6, 0.9}};
    case fridge:
      return {{0.62, 0.6, 1.4}, {0.68, 0.7, 1.9}};
    case wall_cabinet:
      return {{0.34, 0.5, 0.6}, {0.36, 1.2, 0.75}};
    case washing_machine:
      return {{0.6, 0.6, 0.85}, {0.62, 0.6, 0.85}};
    case bathtub:
      return {{0.68, 1.45, 0.55}, {0.78, 1.8, 0.6}};
    case toilet:
      return {{0.64, 0.36, 0.75}, {0.7, 0.4, 0.82}};
    case washbasin:
      return {{0.42, 0.5, 0.85}, {0.5, 0.9, 0.9}};
    case towel_rack:
      return {{0.06, 0.45, 0.6}, {0.1, 0.6, 0.9}};
    case radiator:
      return {{0.09, 0.6, 0.5}, {0.12, 1.4, 0.6}};
    case curtain:
      return {{0.08, 0.3, 1.0}, {0.1, 3.0, 3.1}};
    case blinds:
      return {{0.05, 0.4, 0.5}, {0.05, 2.2, 2.3}};
    case picture:
      return {{0.02, 0.35, 0.3}, {0.03, 1.1, 0.8}};
    case mirror:
      return {{0.02, 0.4, 0.5}, {0.03, 0.8, 1.0}};
  }
  return {};
}

void add_stand_in(FurnitureKind kind, const Vector3& size_m, const FurnitureStyle& style,
                  SceneBuilder& builder) {
  StandInMaker(size_m, style, builder).make(kind);
}

}  // namespace earpoint
