#pragma once

#include <ecorche/envelope/split_tets.h>

#include <vector>

namespace ecorche::envelope {

/// Places of all named vertices. Names are in output order: edges, faces, tets, each ascending.
class Placement {
 public:
  enum class Moved : std::uint8_t { No, Clamped, Repaired };

  /// Raw places of all names, clamped unless options.exact.
  Placement(const mesh::TetMesh& mesh, const tissue::FieldMatrix& fields,
            std::vector<VertexName> names, const EnvelopeOptions& options);

  [[nodiscard]] const std::vector<VertexName>& names() const { return names_; }
  [[nodiscard]] const std::vector<Anatomy::Origin>& origins() const { return origin_; }
  [[nodiscard]] const std::vector<Moved>& moved() const { return moved_; }
  [[nodiscard]] mesh::Vector3 position(std::size_t name) const;

  /// Moves the names of the given split tets towards the mean of their neighbours in their own face
  /// or tet (a barycentric embedding [Tutte 1963]); with `edgesToo` crossings are first spread
  /// evenly over their edges.
  void relax(const std::vector<SplitTet>& all, const std::vector<std::int32_t>& badSplits,
             double strength, bool edgesToo);

 private:
  const mesh::TetMesh& mesh_;
  const tissue::FieldMatrix& fields_;
  double clamp_;
  std::vector<VertexName> names_;
  std::vector<Anatomy::Origin> origin_;
  std::vector<Moved> moved_;

  void placeEdges(bool exact);
  void placeInside(bool exact);
  [[nodiscard]] std::vector<std::size_t> alongEdge(std::size_t begin, std::size_t end) const;
};

}  // namespace ecorche::envelope
