#include <ecorche/studio/theme.h>

#include <QPainter>
#include <QPainterPath>
#include <QPalette>
#include <QPixmap>
#include <QStyleFactory>
#include <cmath>

namespace ecorche::studio {

namespace {

QPalette palette(Theme theme) {
  const bool dark = theme == Theme::Dark;
  const QColor window = dark ? QColor(43, 44, 47) : QColor(236, 236, 233);
  const QColor base = dark ? QColor(32, 33, 36) : QColor(252, 252, 250);
  const QColor text = dark ? QColor(224, 223, 219) : QColor(34, 35, 38);
  const QColor quiet = dark ? QColor(132, 132, 130) : QColor(128, 128, 126);
  const QColor button = dark ? QColor(58, 60, 64) : QColor(222, 222, 218);
  QPalette p;
  p.setColor(QPalette::Window, window);
  p.setColor(QPalette::WindowText, text);
  p.setColor(QPalette::Base, base);
  p.setColor(QPalette::AlternateBase, dark ? QColor(37, 38, 41) : QColor(245, 245, 242));
  p.setColor(QPalette::Text, text);
  p.setColor(QPalette::Button, button);
  p.setColor(QPalette::ButtonText, text);
  p.setColor(QPalette::BrightText, Qt::white);
  p.setColor(QPalette::ToolTipBase, dark ? QColor(24, 25, 27) : QColor(255, 255, 252));
  p.setColor(QPalette::ToolTipText, text);
  p.setColor(QPalette::PlaceholderText, quiet);
  p.setColor(QPalette::Highlight, accentColour());
  p.setColor(QPalette::HighlightedText, Qt::white);
  p.setColor(QPalette::Link, accentColour());
  p.setColor(QPalette::Mid, dark ? QColor(26, 27, 29) : QColor(196, 196, 192));
  for (const auto role : {QPalette::WindowText, QPalette::Text, QPalette::ButtonText})
    p.setColor(QPalette::Disabled, role, quiet);
  return p;
}

}  // namespace

QColor accentColour() { return {201, 95, 43}; }

void applyTheme(QApplication& app, Theme theme) {
  QApplication::setStyle(QStyleFactory::create("Fusion"));
  QApplication::setPalette(palette(theme));
  app.setStyleSheet(
      "QToolTip { padding: 4px; border: 1px solid palette(mid); }"
      "QDockWidget::title { padding: 6px 8px; background: palette(window); }"
      "QToolBar { border: none; spacing: 3px; padding: 4px; }"
      "QToolButton { padding: 5px; border-radius: 4px; border: none; }"
      "QToolButton:checked { background: palette(highlight); }"
      "QToolButton:hover:!checked { background: palette(button); }"
      "QTreeView { border: none; }"
      "QTreeView::item { padding: 3px 0; }"
      "QStatusBar::item { border: none; }"
      "QPushButton { padding: 5px 14px; }"
      "QPushButton#wide { padding: 10px 18px; text-align: left; }");
}

SceneColours sceneColours(Theme theme) {
  SceneColours out;
  if (theme == Theme::Light) {
    out.background = {0.80f, 0.80f, 0.785f, 1.0f};
    out.curve = {0.12f, 0.12f, 0.12f, 1.0f};
  }
  return out;
}

QIcon icon(Glyph glyph, const QColor& colour) {
  constexpr int kSize = 48;  // scaled down: crisp on any screen
  QPixmap pixmap(kSize, kSize);
  pixmap.fill(Qt::transparent);
  QPainter p(&pixmap);
  p.setRenderHint(QPainter::Antialiasing);
  QPen pen(colour, 3.6, Qt::SolidLine, Qt::RoundCap, Qt::RoundJoin);
  p.setPen(pen);
  const auto dot = [&](double x, double y, double r = 4.2) {
    p.setBrush(colour);
    p.drawEllipse(QPointF(x, y), r, r);
    p.setBrush(Qt::NoBrush);
  };
  switch (glyph) {
    case Glyph::Select: {
      QPainterPath path(QPointF(14, 8));
      for (const QPointF q : {QPointF(14, 38), QPointF(22, 31), QPointF(28, 42), QPointF(33, 39.5),
                              QPointF(27.5, 29), QPointF(38, 28)})
        path.lineTo(q);
      path.closeSubpath();
      p.drawPath(path);
      break;
    }
    case Glyph::Draw: {
      QPainterPath path(QPointF(9, 37));
      path.cubicTo(14, 12, 30, 38, 39, 11);
      p.drawPath(path);
      dot(9, 37);
      dot(39, 11);
      break;
    }
    case Glyph::Straight:
      p.drawLine(QPointF(10, 38), QPointF(38, 10));
      dot(10, 38);
      dot(38, 10);
      break;
    case Glyph::Polyline: {
      QPainterPath path(QPointF(9, 38));
      for (const QPointF q : {QPointF(18, 17), QPointF(29, 30), QPointF(39, 10)}) path.lineTo(q);
      p.drawPath(path);
      for (const QPointF q : {QPointF(9, 38), QPointF(18, 17), QPointF(29, 30), QPointF(39, 10)})
        dot(q.x(), q.y(), 3.6);
      break;
    }
    case Glyph::Mirror: {
      QPen dashed = pen;
      dashed.setStyle(Qt::DashLine);
      dashed.setWidthF(2.4);
      p.setPen(dashed);
      p.drawLine(QPointF(24, 6), QPointF(24, 42));
      p.setPen(pen);
      p.drawPolygon(QPolygonF({{18, 14}, {18, 34}, {7, 34}}));
      p.setBrush(colour);
      p.drawPolygon(QPolygonF({{30, 14}, {30, 34}, {41, 34}}));
      break;
    }
    case Glyph::Undo:
    case Glyph::Redo: {
      if (glyph == Glyph::Redo) {
        p.translate(kSize, 0);
        p.scale(-1, 1);
      }
      QPainterPath path(QPointF(12, 18));
      path.lineTo(28, 18);
      path.cubicTo(42, 18, 42, 38, 28, 38);
      path.lineTo(20, 38);
      p.drawPath(path);
      p.drawPolyline(QPolygonF({{19, 10}, {11, 18}, {19, 26}}));
      break;
    }
    case Glyph::Frame:
      for (int k = 0; k < 4; ++k) {
        p.drawPolyline(QPolygonF({{9, 17}, {9, 9}, {17, 9}}));
        p.translate(kSize / 2.0, kSize / 2.0);
        p.rotate(90);
        p.translate(-kSize / 2.0, -kSize / 2.0);
      }
      dot(24, 24, 5);
      break;
    case Glyph::Eye:
    case Glyph::EyeClosed: {
      QPainterPath path(QPointF(6, 24));
      path.quadTo(24, 5, 42, 24);
      path.quadTo(24, 43, 6, 24);
      p.drawPath(path);
      dot(24, 24, 6);
      if (glyph == Glyph::EyeClosed) p.drawLine(QPointF(10, 40), QPointF(38, 8));
      break;
    }
    case Glyph::Lock: {
      QPainterPath bow(QPointF(15, 22));
      bow.lineTo(15, 16);
      bow.cubicTo(15, 4, 33, 4, 33, 16);
      bow.lineTo(33, 22);
      p.drawPath(bow);
      p.setBrush(colour);
      p.drawRoundedRect(QRectF(11, 22, 26, 19), 4, 4);
      break;
    }
  }
  return QIcon(pixmap);
}

}  // namespace ecorche::studio
