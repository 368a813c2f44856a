#pragma once

// As core/precompiled.h, for the window; TBB before Qt, whose macros are words of its own.

#include <ecorche/core/precompiled.h>

#include <QOpenGLWidget>
#include <QtWidgets>
