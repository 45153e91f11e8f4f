<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>
<qgis version="3.22" styleCategories="Symbology|Labeling" labelsEnabled="1">
  <renderer-v2 type="singleSymbol">
    <symbols>
      <symbol type="line" name="0">
        <layer class="SimpleLine">
          <prop k="line_color" v="200,40,30,255"/>
          <prop k="line_width" v="0.3"/>
        </layer>
      </symbol>
    </symbols>
  </renderer-v2>
  <labeling type="simple">
    <settings>
      <text-style isExpression="1" fieldName="lpad(to_string(round(&quot;course_deg&quot;) % 360), 3, '0') || '°  ' || format_number(&quot;distance_m&quot; / 1852, 2) || ' NM'" fontSize="8" fontSizeUnit="Point" textColor="200,40,30,255">
        <text-buffer bufferDraw="1" bufferSize="0.8" bufferColor="255,255,255,220"/>
      </text-style>
      <placement placement="2" placementFlags="2" dist="0.6"/>
    </settings>
  </labeling>
  <layerGeometryType>1</layerGeometryType>
</qgis>
