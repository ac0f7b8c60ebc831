; `llvm-as lanes.ll` writes lanes.bc, which kernels link. Taichi hands over where a variable lies, and not its value.
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"

; read sixteen floats, or doubles, from an address, and write them to one, which need not be at a whole vector; by 256 bits,
; because a load that is wider than the store before it waits until that is in the cache
define void @gen_art_load_f32(i64* %variable, [16 x float]* %lanes) alwaysinline nounwind {
  %address = load i64, i64* %variable
  %address.0 = add i64 %address, 0
  %memory.0 = inttoptr i64 %address.0 to <8 x float>*
  %lane.0 = getelementptr inbounds [16 x float], [16 x float]* %lanes, i64 0, i64 0
  %vector.0 = bitcast float* %lane.0 to <8 x float>*
  %values.0 = load <8 x float>, <8 x float>* %memory.0, align 4
  store <8 x float> %values.0, <8 x float>* %vector.0, align 4
  %address.1 = add i64 %address, 32
  %memory.1 = inttoptr i64 %address.1 to <8 x float>*
  %lane.1 = getelementptr inbounds [16 x float], [16 x float]* %lanes, i64 0, i64 8
  %vector.1 = bitcast float* %lane.1 to <8 x float>*
  %values.1 = load <8 x float>, <8 x float>* %memory.1, align 4
  store <8 x float> %values.1, <8 x float>* %vector.1, align 4
  ret void
}

define void @gen_art_load_f64(i64* %variable, [16 x double]* %lanes) alwaysinline nounwind {
  %address = load i64, i64* %variable
  %address.0 = add i64 %address, 0
  %memory.0 = inttoptr i64 %address.0 to <4 x double>*
  %lane.0 = getelementptr inbounds [16 x double], [16 x double]* %lanes, i64 0, i64 0
  %vector.0 = bitcast double* %lane.0 to <4 x double>*
  %values.0 = load <4 x double>, <4 x double>* %memory.0, align 8
  store <4 x double> %values.0, <4 x double>* %vector.0, align 8
  %address.1 = add i64 %address, 32
  %memory.1 = inttoptr i64 %address.1 to <4 x double>*
  %lane.1 = getelementptr inbounds [16 x double], [16 x double]* %lanes, i64 0, i64 4
  %vector.1 = bitcast double* %lane.1 to <4 x double>*
  %values.1 = load <4 x double>, <4 x double>* %memory.1, align 8
  store <4 x double> %values.1, <4 x double>* %vector.1, align 8
  %address.2 = add i64 %address, 64
  %memory.2 = inttoptr i64 %address.2 to <4 x double>*
  %lane.2 = getelementptr inbounds [16 x double], [16 x double]* %lanes, i64 0, i64 8
  %vector.2 = bitcast double* %lane.2 to <4 x double>*
  %values.2 = load <4 x double>, <4 x double>* %memory.2, align 8
  store <4 x double> %values.2, <4 x double>* %vector.2, align 8
  %address.3 = add i64 %address, 96
  %memory.3 = inttoptr i64 %address.3 to <4 x double>*
  %lane.3 = getelementptr inbounds [16 x double], [16 x double]* %lanes, i64 0, i64 12
  %vector.3 = bitcast double* %lane.3 to <4 x double>*
  %values.3 = load <4 x double>, <4 x double>* %memory.3, align 8
  store <4 x double> %values.3, <4 x double>* %vector.3, align 8
  ret void
}

define void @gen_art_store_f32(i64* %variable, [16 x float]* %lanes) alwaysinline nounwind {
  %address = load i64, i64* %variable
  %address.0 = add i64 %address, 0
  %memory.0 = inttoptr i64 %address.0 to <8 x float>*
  %lane.0 = getelementptr inbounds [16 x float], [16 x float]* %lanes, i64 0, i64 0
  %vector.0 = bitcast float* %lane.0 to <8 x float>*
  %values.0 = load <8 x float>, <8 x float>* %vector.0, align 4
  store <8 x float> %values.0, <8 x float>* %memory.0, align 4
  %address.1 = add i64 %address, 32
  %memory.1 = inttoptr i64 %address.1 to <8 x float>*
  %lane.1 = getelementptr inbounds [16 x float], [16 x float]* %lanes, i64 0, i64 8
  %vector.1 = bitcast float* %lane.1 to <8 x float>*
  %values.1 = load <8 x float>, <8 x float>* %vector.1, align 4
  store <8 x float> %values.1, <8 x float>* %memory.1, align 4
  ret void
}

define void @gen_art_store_f64(i64* %variable, [16 x double]* %lanes) alwaysinline nounwind {
  %address = load i64, i64* %variable
  %address.0 = add i64 %address, 0
  %memory.0 = inttoptr i64 %address.0 to <4 x double>*
  %lane.0 = getelementptr inbounds [16 x double], [16 x double]* %lanes, i64 0, i64 0
  %vector.0 = bitcast double* %lane.0 to <4 x double>*
  %values.0 = load <4 x double>, <4 x double>* %vector.0, align 8
  store <4 x double> %values.0, <4 x double>* %memory.0, align 8
  %address.1 = add i64 %address, 32
  %memory.1 = inttoptr i64 %address.1 to <4 x double>*
  %lane.1 = getelementptr inbounds [16 x double], [16 x double]* %lanes, i64 0, i64 4
  %vector.1 = bitcast double* %lane.1 to <4 x double>*
  %values.1 = load <4 x double>, <4 x double>* %vector.1, align 8
  store <4 x double> %values.1, <4 x double>* %memory.1, align 8
  %address.2 = add i64 %address, 64
  %memory.2 = inttoptr i64 %address.2 to <4 x double>*
  %lane.2 = getelementptr inbounds [16 x double], [16 x double]* %lanes, i64 0, i64 8
  %vector.2 = bitcast double* %lane.2 to <4 x double>*
  %values.2 = load <4 x double>, <4 x double>* %vector.2, align 8
  store <4 x double> %values.2, <4 x double>* %memory.2, align 8
  %address.3 = add i64 %address, 96
  %memory.3 = inttoptr i64 %address.3 to <4 x double>*
  %lane.3 = getelementptr inbounds [16 x double], [16 x double]* %lanes, i64 0, i64 12
  %vector.3 = bitcast double* %lane.3 to <4 x double>*
  %values.3 = load <4 x double>, <4 x double>* %vector.3, align 8
  store <4 x double> %values.3, <4 x double>* %memory.3, align 8
  ret void
}
