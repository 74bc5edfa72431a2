// SPDX-License-Identifier: Apache-2.0
// What each type of light brings to a surface: against closed forms and quadrature, and the four
// functions of light.h against each other.
#include "common/scene/light.h"

#include <gtest/gtest.h>

#include <map>

#include "common/base/errors.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/light_estimates.h"
#include "tests/support/scenes.h"

namespace tallow {
namespace {

using test::estimate;
using test::irradiance;

const Vec3 kUp(0, 1, 0);
constexpr double kPiD = std::numbers::pi;

MeshLight mesh_light(TriangleMesh mesh, Rgb radiance) {
    return {std::make_shared<const MeshEmitter>(std::move(mesh)), radiance};
}

TriangleMesh moved(TriangleMesh mesh, Vec3 by) {
    return transform_mesh(std::move(mesh), {glm::mat3(1), by});
}

TriangleMesh turned_inside_out(TriangleMesh mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

/// A picture of 4 x 3 pixels, one of them bright, no two alike.
std::shared_ptr<const LightImage> small_picture(LightImage::Layout layout) {
    RgbImage image{4, 3, {}};
    for (int i = 0; i < 12; ++i)
        image.pixels.push_back({0.1f + 0.02f * float(i), 0.3f - 0.02f * float(i), 0.05f});
    image.pixels[6] = {3, 2, 5};
    return std::make_shared<const LightImage>(std::move(image), layout);
}

QuadLight textured_quad(float height, float side) {
    QuadLight quad = test::ceiling(height, side, Rgb(2, 1, 0.5f));
    quad.texture = small_picture(LightImage::Layout::flat);
    return quad;
}

/// Irradiance at the origin, facing up, by quadrature over a square ceiling of a radiance.
template <class Radiance>
double ceiling_irradiance(double height, double side, Radiance&& radiance) {
    constexpr int kSteps = 800;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const double a = (i + 0.5) / kSteps - 0.5, b = (j + 0.5) / kSteps - 0.5;
            const double d2 = side * side * (a * a + b * b) + height * height;
            sum += radiance(a, b) * height * height / (d2 * d2);
        }
    return sum * side * side / kSteps / kSteps;
}

// A disc of radius R above a surface that faces it: E = pi L R^2 / (R^2 + h^2). Measured
// 2e-4 where the light is nearest.
TEST(Lights, DiscAboveASurface) {
    for (const float h : {0.1f, 1.0f, 10.0f, 1000.0f}) {
        const Light light{DiscLight{{0, h, 0}, -kUp, 2, {1, 2, 4}}};
        const double E = kPiD * 4 / (4 + double(h) * h);
        const DVec3 got = irradiance(light, Vec3(0), kUp, 1 << 16);
        EXPECT_NEAR(got.x, E, 1e-3 * E) << h;
        EXPECT_NEAR(got.z, 4 * E, 4e-3 * E);
        EXPECT_EQ(irradiance(light, {0, 2 * h, 0}, -kUp).x, 0) << "behind it";
    }
}

/// Form factor from a surface at the origin, facing up, to the rectangle [0, a] x [0, b] at height
/// h (Siegel, Howell, configuration 2 of the catalogue of form factors).
double corner_form_factor(double a, double b, double h) {
    const double x = a / h, y = b / h, p = std::sqrt(1 + x * x), q = std::sqrt(1 + y * y);
    return (x / p * std::atan(y / p) + y / q * std::atan(x / q)) / (2 * kPiD);
}

// From all distances, by area and by solid angle, below the quad and beside it; [0, 1] x [0, 2].
TEST(Lights, QuadNearAndFar) {
    for (const float h : {1e-4f, 0.01f, 0.3f, 1.0f, 2.0f, 20.0f})
        for (const float x : {0.0f, 0.5f, 0.9f, 1.5f}) {
            const Light light{QuadLight{{0.5f - x, h, 1}, {1, 0, 0}, {0, 0, 2}, -kUp, Rgb(1)}};
            const double sign = x > 1 ? -1 : 1;
            const double E = kPiD * (corner_form_factor(x, 2, h) +
                                     sign * corner_form_factor(std::abs(1 - x), 2, h));
            // Measured 2e-6.
            EXPECT_NEAR(irradiance(light, Vec3(0), kUp).x, E, 1e-5 * E) << h << ' ' << x;
            EXPECT_EQ(irradiance(light, {0, 2 * h, 0}, -kUp).x, 0) << "behind it";
        }
}

// On the quad, in its plane, a rounding error below: nothing or finite light.
TEST(Lights, QuadThatTouches) {
    const Light light{test::ceiling(1, 2, Rgb(1))};
    for (const Vec3 x : {Vec3(0, 1, 0), Vec3(0.3f, 0x1.fffffep-1f, 0.7f), Vec3(1, 1, 1),
                         Vec3(3, 1, 0), Vec3(1, 0x1.fffffep-1f, 0), Vec3(0.5f, 1 - 1e-5f, 1)})
        for (int k = 0; k < 64; ++k) {
            const auto sample = sample_light(light, x, kUp, sobol_2d(std::uint32_t(k), 3));
            if (!sample) continue;
            EXPECT_TRUE(is_finite(sample->radiance) && is_finite(sample->w_i));
            EXPECT_LE(sample->radiance.r, kTwoPi * 1.001f);
        }
}

// A small disc seen under an angle, from the side: L A cos cos / d^2.
TEST(Lights, SmallDiscFromTheSide) {
    const Vec3 normal = glm::normalize(Vec3(-1, -2, 0));
    const Light light{DiscLight{{30, 40, 0}, normal, 0.01f, Rgb(1)}};
    const double cos_light = (3.0 / 5 + 2 * 4.0 / 5) / std::sqrt(5.0);
    const double E = kPiD * 1e-4 * 0.8 * cos_light / 2500;
    EXPECT_NEAR(irradiance(light, Vec3(0), kUp).x, E, 1e-5 * E);
}

// A sphere wholly above the horizon: E = pi L (R / d)^2 cos.
TEST(Lights, Sphere) {
    const Light light{SphereLight{{3, 4, 0}, 2, Rgb(1)}};
    const double E = kPiD * 4 / 25 * 0.8;
    EXPECT_NEAR(irradiance(light, Vec3(0), kUp).x, E, 1e-4 * E);
}

// A cube's lower side is a square ceiling; its other sides are not seen from below its middle.
TEST(Lights, MeshCube) {
    const Light light{mesh_light(moved(cube_mesh({glm::mat3(3), Vec3(0)}), {0, 3.5f, 0}), Rgb(1))};
    const double E = ceiling_irradiance(2, 3, [](double, double) { return 1; });
    EXPECT_NEAR(irradiance(light, Vec3(0), kUp, 1 << 16).x, E, 2e-5 * E);  // measured 1.3e-6
}

// Triangles with corners on a sphere of radius 2 bound a solid that is smaller, by a quarter with
// each split: measured 0.28 % and 0.071 %.
TEST(Lights, MeshBallIsASphere) {
    const double E = kPiD * 4 / 25 * 0.8;
    const auto missing = [&](int splits) {
        const auto ball = test::ball_mesh(splits, [](Vec3) { return 2; });
        const Light light{mesh_light(moved(ball, {3, 4, 0}), Rgb(1))};
        return 1 - irradiance(light, Vec3(0), kUp, 1 << 18).x / E;
    };
    EXPECT_NEAR(missing(4), 0.0028, 2e-4);
    EXPECT_NEAR(missing(5), 0.0028 / 4, 2e-4);
}

// Flux through a plane below a spot: 2 pi I times the integral of its falloff over the cosine.
TEST(Lights, SpotFluxThroughAPlane) {
    const SpotLight spot{{0, 2, 0}, -kUp, Rgb(3), 0.9f, 0.7f};
    double flux = 0;
    constexpr int kRings = 20000;
    const double reach = 2 * std::sqrt(1 / (0.7 * 0.7) - 1);
    for (int i = 0; i < kRings; ++i) {
        const double r = (i + 0.5) / kRings * reach;
        const Vec2 u(0.5f);
        flux += test::irradiance_sample({spot}, {float(r), 0, 0}, kUp, u).r * 2 * kPiD * r * reach /
                kRings;
    }
    // The cubic step has the mean 1/2 between its ends.
    const double expected = 2 * kPiD * 3 * (0.1 + 0.2 / 2);
    EXPECT_NEAR(flux, expected, 1e-5 * expected);  // measured 1e-7
}

TEST(Lights, TexturedQuad) {
    const QuadLight quad = textured_quad(2, 3);
    const DVec3 got = irradiance({quad}, Vec3(0), kUp, 1 << 16);
    for (int c = 0; c < 3; ++c) {
        const double E = ceiling_irradiance(2, 3, [&](double a, double b) {
            return double(quad.radiance[c]) *
                   quad.texture->at({float(0.5 - a), float(0.5 - b)}).color[c];
        });
        EXPECT_NEAR(got[c], E, 2e-5 * E) << c;  // measured 2e-6
    }
}

// A constant picture changes nothing, not even the samples.
TEST(Lights, ConstantTextureIsNone) {
    QuadLight plain = test::ceiling(2, 3, Rgb(3)), textured = test::ceiling(2, 3, Rgb(4));
    textured.texture = std::make_shared<const LightImage>(
        RgbImage{5, 4, std::vector<Rgb>(20, Rgb(0.75f))}, LightImage::Layout::flat);
    const DVec3 E = irradiance({plain}, Vec3(0), kUp);
    EXPECT_NEAR(irradiance({textured}, Vec3(0), kUp).x, E.x, 1e-6 * E.x);
    EXPECT_EQ(textured.texture->share(), 0);
}

// The picture stands upright, not mirrored, for somebody the quad shines on: looking along -z at a
// quad that shines along +z, right is +x.
TEST(Lights, TextureOrientation) {
    QuadLight quad{Vec3(0), {-2, 0, 0}, {0, 2, 0}, {0, 0, 1}, Rgb(1)};  // u = forward x up
    RgbImage image{2, 2, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}};
    quad.texture = std::make_shared<const LightImage>(image, LightImage::Layout::flat);
    const auto seen_at = [&](float x, float y) {
        return see_light({quad}, {{x, y, 5}, {0, 0, -1}})->radiance;
    };
    EXPECT_EQ(seen_at(-0.9f, 0.9f), Rgb(1, 0, 0));
    EXPECT_EQ(seen_at(0.9f, 0.9f), Rgb(0, 1, 0));
    EXPECT_EQ(seen_at(-0.9f, -0.9f), Rgb(0, 0, 1));
    EXPECT_EQ(seen_at(0.9f, -0.9f), Rgb(1, 1, 1));
    EXPECT_FALSE(see_light({quad}, {{0, 0, -5}, {0, 0, 1}})) << "from behind";
}

// Inside a closed emitter of constant radiance: E = pi L wherever one stands and faces.
TEST(Lights, FurnaceOfMeshes) {
    const auto ball = test::ball_mesh(3, [](Vec3) { return 5; });
    const Light sphere{mesh_light(turned_inside_out(ball), Rgb(1))};
    const Light room{mesh_light(turned_inside_out(cube_mesh({glm::mat3(8), Vec3(0)})), Rgb(1))};
    for (const Light* light : {&sphere, &room})
        for (const Vec3 x : {Vec3(0), Vec3(1, -2, 1.5f)})
            for (const Vec3 n : {kUp, glm::normalize(Vec3(1, -3, 2))}) {
                EXPECT_NEAR(irradiance(*light, x, n, 1 << 17).x, kPiD, 1e-3);  // measured 2e-4
                const auto seen = test::seen_irradiance(*light, x, n, 1000);
                EXPECT_NEAR(seen.mean.x, kPiD, 1e-6);
            }
}

// Two discs and the inside of a tube between them, all of radiance 1, enclose the receiver.
TEST(Lights, FurnaceOfSeveralLights) {
    TriangleMesh tube;
    constexpr std::uint32_t kSides = 64;
    for (std::uint32_t i = 0; i < kSides; ++i) {
        const float phi = kTwoPi * float(i) / kSides;
        for (const float y : {-3.0f, 3.0f})
            tube.vertices.push_back({2 * std::cos(phi), y, 2 * std::sin(phi)});
        const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % kSides);
        tube.triangles.insert(tube.triangles.end(), {{a, a + 1, b + 1}, {a, b + 1, b}});
    }
    const bool inward = glm::dot(triangle_normal(tube, 0), tube.vertices[0] - Vec3(0, -3, 0)) < 0;
    const Light wall{mesh_light(inward ? tube : turned_inside_out(tube), Rgb(1))};
    const Light top{DiscLight{{0, 3, 0}, -kUp, 2, Rgb(1)}};
    const Light bottom{DiscLight{{0, -3, 0}, kUp, 2, Rgb(1)}};
    const Vec3 x(0.5f, 0.7f, -0.2f);
    for (const Vec3 n : {kUp, glm::normalize(Vec3(1, 0.3f, 2))}) {
        double E = 0;
        for (const Light* light : {&wall, &top, &bottom}) E += irradiance(*light, x, n, 1 << 17).x;
        EXPECT_NEAR(E, kPiD, 5e-3);  // measured 1.3e-3: the tube has 64 flat sides
    }
}

std::map<std::string, Light> lights_with_a_size() {
    EnvironmentLight sky{Rgb(1, 2, 3)};
    sky.image = small_picture(LightImage::Layout::directions);
    sky.rotation = 0.7f;
    TriangleMesh ring = test::bumpy_mesh(3);  // hides parts of itself
    for (Vec3& v : ring.vertices) v = 0.3f * v + Vec3(1, 6, 0);
    return {{"quad", {test::ceiling(2, 3, {1, 2, 4})}},
            {"textured quad", {textured_quad(2, 3)}},
            {"disc", {DiscLight{{1, 3, 0}, glm::normalize(Vec3(-0.2f, -1, 0)), 2, Rgb(1)}}},
            {"sphere", {SphereLight{{1, 4, 0}, 2, Rgb(1)}}},
            {"sphere at the horizon", {SphereLight{{4, 1, 0}, 2, Rgb(1)}}},
            {"cube", {mesh_light(cube_mesh({glm::mat3(2), {1, 3, 0}}), Rgb(1))}},
            {"bumpy ball", {mesh_light(ring, Rgb(1))}},
            {"constant environment", {EnvironmentLight{Rgb(1, 2, 3)}}},
            {"sky", {sky}}};
}

void expect_equal(const test::Estimate& a, const test::Estimate& b, const std::string& what) {
    for (int c = 0; c < 3; ++c) {
        const double error = std::hypot(a.mean_error[c], b.mean_error[c]) + 1e-6 * a.mean[c];
        EXPECT_NEAR(a.mean[c], b.mean[c], 4 * error) << what << ", channel " << c;  // 4 sigma
        EXPECT_LT(error, 0.01 * a.mean[c]) << what << ": too few samples to tell";
    }
}

// What looking around finds, what sample_light() draws, and what sample_light_point() sends.
TEST(Lights, AllFunctionsTellTheSameLight) {
    for (const auto& [name, light] : lights_with_a_size())
        for (const Vec3 n : {kUp, glm::normalize(Vec3(1, 1, 0.5f))}) {
            const auto drawn = test::random_irradiance(light, Vec3(0), n, 200000);
            expect_equal(drawn, test::seen_irradiance(light, Vec3(0), n, 400000), name + " seen");
            expect_equal(drawn, test::point_irradiance(light, Vec3(0), n, 400000), name + " sent");
        }
}

// sample_light() without a normal, as a point inside a volume asks: the integral of radiance over
// all directions.
TEST(Lights, FluenceInAVolume) {
    for (const auto& [name, light] : lights_with_a_size()) {
        const auto drawn = estimate(200000, [&](int k) {
            const auto sample =
                sample_light(light, Vec3(0), std::nullopt, test::random_point(8, k));
            return sample ? sample->radiance : Rgb(0);
        });
        const auto seen = estimate(400000, [&](int k) {
            const Vec2 u = test::random_point(9, k);
            const float z = 1 - 2 * u.x, s = std::sqrt(1 - z * z), phi = kTwoPi * u.y;
            const auto emission =
                see_light(light, {Vec3(0), {s * std::cos(phi), s * std::sin(phi), z}});
            return emission ? 4 * kPi * emission->radiance : Rgb(0);
        });
        expect_equal(drawn, seen, name);
    }
}

// The distance of a sample is where the light is seen in that direction.
TEST(Lights, SamplesLieWhereTheLightIsSeen) {
    for (const auto& [name, light] : lights_with_a_size()) {
        int missed = 0;
        for (int k = 0; k < 1000; ++k) {
            const auto sample = sample_light(light, Vec3(0), kUp, test::random_point(10, k));
            if (!sample) continue;
            const auto seen = see_light(light, {Vec3(0), sample->w_i});
            if (!seen) {
                ++missed;
            } else if (!std::isinf(seen->t)) {
                EXPECT_NEAR(seen->t, sample->distance, 1e-4f * sample->distance)  // measured 1e-5
                    << name;
            }
        }
        EXPECT_LE(missed, 2) << name;  // rays through rims and edges; measured 0
    }
}

TEST(Lights, OnlyLightsWithoutASizeAreDelta) {
    for (const auto& [name, light] : lights_with_a_size()) EXPECT_FALSE(is_delta(light)) << name;
    for (const LightShape& shape :
         {LightShape(PointLight{}), LightShape(SpotLight{}), LightShape(DirectionalLight{})}) {
        EXPECT_TRUE(is_delta({shape}));
        EXPECT_FALSE(see_light({shape}, {Vec3(0), kUp}));
    }
}

TEST(Lights, DeltaLightsSendWhatTheySample) {
    const std::vector<Light> lights = {{PointLight{{3, 4, 0}, Rgb(25)}},
                                       {SpotLight{{3, 4, 0}, -kUp, Rgb(25), 0.9f, 0.7f}},
                                       {DirectionalLight{{0.6f, -0.8f, 0}, Rgb(2)}}};
    for (const Light& light : lights)
        EXPECT_NEAR(test::point_irradiance(light, Vec3(0), kUp, 1).mean.x,
                    test::random_irradiance(light, Vec3(0), kUp, 1).mean.x, 1e-6);
}

TEST(MeshEmitter, DrawsUniformlyByArea) {
    TriangleMesh mesh;  // two triangles, one of three times the area
    mesh.vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-3, 0, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 3, 1}};
    const MeshEmitter emitter(mesh);
    EXPECT_EQ(emitter.area(), 2);
    DVec3 sum(0.0);
    constexpr int kCount = 1 << 14;
    for (int k = 0; k < kCount; ++k) {
        const MeshEmitter::Point p = emitter.draw(sobol_2d(std::uint32_t(k), 3));
        EXPECT_EQ(p.normal, kUp);
        sum += DVec3(p.position) / double(kCount);
    }
    // Centroids (1/3, 0, 1/3) of weight 1/4 and (-1, 0, 1/3) of weight 3/4.
    EXPECT_NEAR(sum.x, -2.0 / 3, 1e-5);  // measured 2e-6
    EXPECT_NEAR(sum.z, 1.0 / 3, 1e-5);
}

TEST(MeshEmitter, IsOpaqueToItself) {
    // Two squares, one behind the other, both facing down.
    TriangleMesh mesh;
    for (const float y : {2.0f, 3.0f})
        for (const Vec2 p : {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)})
            mesh.vertices.push_back({p.x, y, p.y});
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    ASSERT_EQ(triangle_normal(mesh, 0), -kUp);
    const Light both{mesh_light(mesh, Rgb(1))};
    const double E = ceiling_irradiance(2, 2, [](double, double) { return 1; });
    EXPECT_NEAR(irradiance(both, Vec3(0), kUp, 1 << 16).x, E, 2e-5 * E);  // measured 1e-6
    EXPECT_FALSE(see_light(both, {{0, 5, 0}, -kUp})) << "from behind";
    EXPECT_NEAR(see_light(both, {{0, 2.5f, 0}, kUp})->t, 0.5f, 1e-6f);
}

TEST(MeshEmitter, HashSeesEveryVertexAndTriangle) {
    const TriangleMesh cube = cube_mesh({});
    const std::uint64_t hash = MeshEmitter(cube).hash();
    EXPECT_EQ(MeshEmitter(cube).hash(), hash);
    TriangleMesh other = cube;
    other.vertices[7].z += 1e-6f;
    EXPECT_NE(MeshEmitter(other).hash(), hash);
    EXPECT_NE(MeshEmitter(turned_inside_out(cube)).hash(), hash);
}

TEST(MeshEmitter, RefusesAMeshThatFloatsCannotHold) {
    EXPECT_THROW(MeshEmitter(cube_mesh({glm::mat3(1e30f), Vec3(0)})), InputError);
    EXPECT_THROW(MeshEmitter(cube_mesh({glm::mat3(kInfinity), Vec3(0)})), InputError);
}

}  // namespace
}  // namespace tallow
