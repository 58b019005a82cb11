// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A factor is a residual of a few variables, r(x_1, ..., x_n), and costs |U r|^2 (noise.h) or rho of that
// (robust.h). To make a new kind, write a small struct, a FactorModel; the rest (types, whitening, storage)
// follows from it:
//
//   struct RangeFactor {                                    // distance from a pose to a point
//     using Variables = VariableList<SE3, Vector<3>>;       // what it reads, in order
//     static constexpr int kDim = 1;                        // of the residual
//     double range_m = 0.0;                                 // its measurement
//     Vector<1> evaluate(const SE3& T_W_B, const Vector<3>& p_W,
//                        Eigen::Matrix<double, 1, 6>* J_pose, Eigen::Matrix<double, 1, 3>* J_point) const;
//   };
//   graph.add(RangeFactor{3.2}, {pose_key, point_key}, Noise<1>::sigma(0.1), Robust::huber(2.0));
//
// Jacobians are d r / d d_k for x_k * Exp(d_k) at d_k = 0: kDim x tangent dimension. The pointers are all
// null or none is. A model that cannot be evaluated where it is (a point behind the camera) returns zeros for
// residual and Jacobians. Every model's Jacobians are checked by one line of
// tests/core/graph/factor_testing.h.
//
// A factor whose number of variables is known at run time only derives from Factor itself (see marginal.h).

#include <array>
#include <concepts>
#include <tuple>
#include <utility>
#include <vector>

#include "core/graph/key.h"
#include "core/graph/manifold.h"
#include "core/graph/noise.h"

namespace covey::graph {

template <typename... Ts>
struct VariableList {
  static constexpr std::size_t kCount = sizeof...(Ts);
};

// When and by which sensor a residual was measured: errors of one series hang together over time.
struct Occasion {
  int series = 0;
  double time_s = 0.0;
};

class Factor {
 public:
  Factor(std::vector<Key> keys, std::vector<VariableType> types, int residual_dim)
      : keys_(std::move(keys)), types_(std::move(types)), residual_dim_(residual_dim) {}
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;
  virtual ~Factor() = default;

  const std::vector<Key>& keys() const { return keys_; }
  const std::vector<VariableType>& types() const { return types_; }
  int residual_dim() const { return residual_dim_; }

  // The whitened residual and its Jacobians. x[k]: the ambient doubles of keys()[k]. jacobians: null, or for
  // each k either null or residual_dim x tangent doubles, row-major.
  virtual void evaluate(const double* const* x, double* residual, double* const* jacobians) const = 0;
  // The whitened residual's covariance where it is not the identity that a solve takes it for (reduced.h), else null.
  virtual const Eigen::MatrixXd* spread() const { return nullptr; }
  // A model has a member `occasion` for it, or none: then its errors hang together with no others.
  virtual const Occasion* occasion() const { return nullptr; }

 private:
  std::vector<Key> keys_;
  std::vector<VariableType> types_;
  int residual_dim_;
};

namespace internal {

template <typename Model, typename Variables>
class ModelFactor;

template <typename Model, typename... Ts>
class ModelFactor<Model, VariableList<Ts...>> final : public Factor {
 public:
  ModelFactor(const Model& model, const std::array<Key, sizeof...(Ts)>& keys, const Noise<Model::kDim>& noise)
      : Factor({keys.begin(), keys.end()}, {Manifold<Ts>::kType...}, Model::kDim),
        model_(model),
        noise_(noise) {}

  void evaluate(const double* const* x, double* residual, double* const* jacobians) const override {
    evaluate(x, residual, jacobians, std::index_sequence_for<Ts...>{});
  }

  const Occasion* occasion() const override {
    if constexpr (requires { model_.occasion; }) {
      return &model_.occasion;
    } else {
      return nullptr;
    }
  }

 private:
  template <typename T>
  using Jacobian = Eigen::Matrix<double, Model::kDim, Manifold<T>::kTangent>;

  template <std::size_t... K>
  void evaluate(const double* const* x, double* residual, double* const* jacobians,
                std::index_sequence<K...>) const {
    std::tuple<Jacobian<Ts>...> J;
    const Vector<Model::kDim> r =
        model_.evaluate(Manifold<Ts>::load(x[K])..., (jacobians ? &std::get<K>(J) : nullptr)...);
    Eigen::Map<Vector<Model::kDim>> out(residual);
    if (noise_.is_unit()) {
      out = r;
    } else {
      out.noalias() = noise_.sqrt_information() * r;
    }
    if (jacobians) (store(std::get<K>(J), jacobians[K]), ...);
  }

  template <typename Matrix>
  void store(const Matrix& J, double* row_major) const {
    if (!row_major) return;
    constexpr int kOrder = Matrix::ColsAtCompileTime == 1 ? Eigen::ColMajor : Eigen::RowMajor;
    Eigen::Map<Eigen::Matrix<double, Matrix::RowsAtCompileTime, Matrix::ColsAtCompileTime, kOrder>> out(
        row_major);
    if (noise_.is_unit()) {
      out = J;
    } else {
      out.noalias() = noise_.sqrt_information() * J;
    }
  }

  Model model_;
  Noise<Model::kDim> noise_;
};

template <typename Model, typename Variables>
struct EvaluatesTo : std::false_type {};
template <typename Model, typename... Ts>
requires requires(const Model& model, const Ts&... x,
                  Eigen::Matrix<double, Model::kDim, Manifold<Ts>::kTangent>*... J) {
  { model.evaluate(x..., J...) } -> std::convertible_to<Vector<Model::kDim>>;
}
struct EvaluatesTo<Model, VariableList<Ts...>> : std::true_type {};

}  // namespace internal

template <typename Model>
concept FactorModel =
    std::copy_constructible<Model> && internal::EvaluatesTo<Model, typename Model::Variables>::value;

}  // namespace covey::graph
